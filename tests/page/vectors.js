//! The protocol's golden vectors for the page's tests: bytes and exact JSON.

import { readFileSync, readdirSync } from "node:fs";

const ROOT = new URL("../../protocol/vectors/", import.meta.url);

/** The names of the vectors of a folder. */
export const names = (folder) =>
  readdirSync(new URL(`${folder}/`, ROOT))
    .filter((name) => name.endsWith(".hex"))
    .map((name) => name.slice(0, -4));

/** The bytes of a vector. */
export const bytesOf = (folder, name) =>
  new Uint8Array(Buffer.from(read(folder, `${name}.hex`).replace(/\s/g, ""), "hex"));

/** The JSON of a vector. Integers that no double can hold are BigInts. */
export function jsonOf(folder, name) {
  const marked = read(folder, `${name}.json`).replace(/(?<=[\s[:,])(\d{16,})(?=[\s,\]}])/g, '"big:$1"');
  return JSON.parse(marked, (_, value) => {
    if (typeof value !== "string" || !value.startsWith("big:")) return value;
    const big = BigInt(value.slice(4));
    return big <= BigInt(Number.MAX_SAFE_INTEGER) ? Number(big) : big;
  });
}

const read = (folder, file) => readFileSync(new URL(`${folder}/${file}`, ROOT), "utf8");
