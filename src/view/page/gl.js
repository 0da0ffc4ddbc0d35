//! WebGL2 in the few words that the plane needs: two programs, and buffers that grow and are written by blocks.
//!
//! In: a context. Out: programs with their places, buffers. Invariants: a buffer grows by doubling and is then
//! written anew. Must not know: skeletons, cameras.

/** Texels in a row of a texture of strips. */
const TEXELS = 1024;
/** Numbers that a strip takes: two ends; a colour of 24 bits, how far it hides what is below, half a width, nothing. */
export const STRIP = 8;

const FLAT_VERTEX = `#version 300 es
layout(location = 0) in vec2 place;
uniform vec4 view;
uniform float size;
void main() {
  gl_Position = vec4(place * view.xy + view.zw, 0.0, 1.0);
  gl_PointSize = size;
}`;

const FLAT_FRAGMENT = `#version 300 es
precision mediump float;
uniform vec4 color;
uniform bool isRound;
out vec4 pixel;
void main() {
  if (isRound && length(gl_PointCoord - 0.5) > 0.5) discard;
  pixel = vec4(color.rgb * color.a, color.a);
}`;

/**
 * A strip of a width in pixels from one place to another: two triangles. Strips lie in a texture, two texels each, since
 * instances of so few corners are slow where WebGL has no graphics card.
 */
const STRIP_VERTEX = `#version 300 es
uniform highp sampler2D strips;
uniform vec4 view;
uniform vec2 pixels;
out vec4 color;
const int CORNER[6] = int[6](0, 1, 2, 2, 1, 3);
void main() {
  int strip = gl_VertexID / 6;
  int corner = CORNER[gl_VertexID % 6];
  ivec2 at = ivec2(2 * (strip % ${TEXELS / 2}), strip / ${TEXELS / 2});
  vec4 ends = texelFetch(strips, at, 0);
  vec4 looks = texelFetch(strips, at + ivec2(1, 0), 0);
  vec2 a = (ends.xy * view.xy + view.zw) * pixels;
  vec2 b = (ends.zw * view.xy + view.zw) * pixels;
  vec2 along = length(b - a) > 1e-6 ? normalize(b - a) : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x) * (corner % 2 == 0 ? looks.z : -looks.z);
  vec2 end = corner < 2 ? a - 0.5 * along * looks.z : b + 0.5 * along * looks.z;
  gl_Position = vec4((end + across) / pixels, 0.0, 1.0);
  int tint = int(looks.x);
  vec3 rgb = vec3(tint >> 16, (tint >> 8) & 255, tint & 255) / 255.0;
  color = vec4(rgb * looks.y, looks.y);
}`;

const STRIP_FRAGMENT = `#version 300 es
precision mediump float;
in vec4 color;
out vec4 pixel;
void main() { pixel = color; }`;

/** Compiles both programs. @param {WebGL2RenderingContext} gl */
export const programs = (gl) => ({
  flat: program(gl, FLAT_VERTEX, FLAT_FRAGMENT, ["view", "size", "color", "isRound"]),
  strip: program(gl, STRIP_VERTEX, STRIP_FRAGMENT, ["view", "pixels", "strips"]),
});

function program(gl, vertex, fragment, names) {
  const made = gl.createProgram();
  for (const [type, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`a shader does not link: ${gl.getProgramInfoLog(made)}`);
  }
  const places = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(made, name)]));
  return { program: made, ...places };
}

/** A buffer, and the array that is written to it. */
export class Buffer {
  /** @param {WebGL2RenderingContext} gl @param {Float32ArrayConstructor | Uint32ArrayConstructor} type */
  constructor(gl, target, type) {
    this.gl = gl;
    this.target = target;
    this.type = type;
    this.array = new type(0);
    this.made = gl.createBuffer();
  }

  /** Makes room for so many numbers. True if what was there has to be written again. */
  reserve(length) {
    if (length <= this.array.length) return false;
    this.array = new this.type(Math.max(length, 2 * this.array.length, 1024));
    this.gl.bindBuffer(this.target, this.made);
    this.gl.bufferData(this.target, this.array.byteLength, this.gl.DYNAMIC_DRAW);
    return true;
  }

  /** Writes a range of the array to the buffer, which must be bound. */
  write(from, to) {
    if (to > from) this.gl.bufferSubData(this.target, from * 4, this.array, from, to - from);
  }

  bind() {
    this.gl.bindBuffer(this.target, this.made);
  }
}

/** Strips in a texture, and the array that is written to it. */
export class StripTexture {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.array = new Float32Array(0);
    this.made = gl.createTexture();
    this.bind();
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    const rows = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    /** The most strips that there may be. */
    this.most = (Math.min(rows, 4096) * TEXELS) / 2;
  }

  bind() {
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.made);
  }

  /** Makes room for so many strips, or the most that there may be. */
  reserve(strips) {
    const { gl } = this;
    const rows = Math.ceil((2 * Math.min(strips, this.most)) / TEXELS);
    if (rows * TEXELS * 4 <= this.array.length) return;
    const grown = Math.min(this.most / (TEXELS / 2), Math.max(rows, (2 * this.array.length) / (4 * TEXELS)));
    this.array = new Float32Array(grown * TEXELS * 4);
    this.bind();
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, TEXELS, grown, 0, gl.RGBA, gl.FLOAT, null);
  }

  /** Writes the first strips of the array to the texture. */
  write(strips) {
    const { gl } = this;
    this.bind();
    const rows = Math.ceil((2 * strips) / TEXELS);
    if (rows > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, TEXELS, rows, gl.RGBA, gl.FLOAT, this.array);
  }
}
