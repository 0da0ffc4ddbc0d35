// The list of streams: asked for every second while somebody looks, with links to what each of them shows.
"use strict";

const FORMS = ["svg", "json", "geojson"];

function row(stream) {
  const { name, frame, points, consumers } = stream.info;
  const row = document.createElement("tr");
  for (const word of [name, frame, points, consumers]) row.insertCell().textContent = word;
  const links = row.insertCell();
  for (const form of FORMS) {
    const link = document.createElement("a");
    link.href = `api/streams/${encodeURIComponent(name)}/snapshot?format=${form}`;
    link.textContent = form;
    links.append(link);
  }
  return row;
}

async function show() {
  const says = document.getElementById("says");
  try {
    const status = await (await fetch("api/streams")).json();
    says.textContent = `${status.software}, ${status.streams.length} streams, ${status.connections} connections`;
    document.getElementById("streams").replaceChildren(...status.streams.map(row));
  } catch {
    says.textContent = "The daemon does not answer.";
  }
}

show();
setInterval(() => document.hidden || show(), 1000);
