//! WebGL2 in the few words that the plane needs: two programs, and buffers that grow and are written by blocks.
//!
//! In: a context. Out: programs with their places, buffers. Invariants: a buffer grows by doubling and is then
//! written anew. Must not know: skeletons, cameras.

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

/** A strip of a width in pixels from one place to another, one an instance. */
const STRIP_VERTEX = `#version 300 es
layout(location = 0) in vec4 ends;
layout(location = 1) in vec4 tint;
layout(location = 2) in float width;
uniform vec4 view;
uniform vec2 pixels;
out vec4 color;
void main() {
  vec2 a = (ends.xy * view.xy + view.zw) * pixels;
  vec2 b = (ends.zw * view.xy + view.zw) * pixels;
  vec2 along = length(b - a) > 1e-6 ? normalize(b - a) : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x) * (gl_VertexID % 2 == 0 ? width : -width);
  vec2 end = gl_VertexID < 2 ? a - 0.5 * along * width : b + 0.5 * along * width;
  gl_Position = vec4((end + across) / pixels, 0.0, 1.0);
  color = vec4(tint.rgb * tint.a, tint.a);
}`;

const STRIP_FRAGMENT = `#version 300 es
precision mediump float;
in vec4 color;
out vec4 pixel;
void main() { pixel = color; }`;

/** Compiles both programs. @param {WebGL2RenderingContext} gl */
export const programs = (gl) => ({
  flat: program(gl, FLAT_VERTEX, FLAT_FRAGMENT, ["view", "size", "color", "isRound"]),
  strip: program(gl, STRIP_VERTEX, STRIP_FRAGMENT, ["view", "pixels"]),
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
