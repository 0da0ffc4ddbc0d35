//! The parts of WebGL2 that the plane needs: two shader programs, and buffers that grow and are written by ranges.
//!
//! In: a context.
//! Out: programs with the locations of their uniforms; buffers.
//! Invariants: a buffer grows by doubling, and then everything in it has to be written again.
//! Must not know: skeletons, cameras.

/** Texels in a row of a texture of strips. */
const TEXELS = 1024;
/** Numbers of a strip: two ends; a colour of 24 bits, an opacity, half a width, padding. */
export const STRIP = 8;

const FLAT_VERTEX = `#version 300 es
layout(location = 0) in vec2 position;
uniform vec4 view;
uniform float size;
void main() {
  gl_Position = vec4(position * view.xy + view.zw, 0.0, 1.0);
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
 * A strip between two positions, with a width in pixels: two triangles. Strips are stored in a texture, two texels
 * each, since instancing with so few vertices is slow where the processor emulates WebGL.
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
  vec4 style = texelFetch(strips, at + ivec2(1, 0), 0);
  vec2 a = (ends.xy * view.xy + view.zw) * pixels;
  vec2 b = (ends.zw * view.xy + view.zw) * pixels;
  vec2 along = length(b - a) > 1e-6 ? normalize(b - a) : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x) * (corner % 2 == 0 ? style.z : -style.z);
  vec2 end = corner < 2 ? a - 0.5 * along * style.z : b + 0.5 * along * style.z;
  gl_Position = vec4((end + across) / pixels, 0.0, 1.0);
  int tint = int(style.x);
  vec3 rgb = vec3(tint >> 16, (tint >> 8) & 255, tint & 255) / 255.0;
  color = vec4(rgb * style.y, style.y);
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
  const compiled = gl.createProgram();
  for (const [type, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(compiled, shader);
  }
  gl.linkProgram(compiled);
  if (!gl.getProgramParameter(compiled, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`a shader does not link: ${gl.getProgramInfoLog(compiled)}`);
  }
  const uniforms = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(compiled, name)]));
  return { program: compiled, ...uniforms };
}

/** A buffer of the graphics card, and the array that is uploaded to it. */
export class Buffer {
  /** @param {WebGL2RenderingContext} gl @param {Float32ArrayConstructor | Uint32ArrayConstructor} type */
  constructor(gl, target, type) {
    this.gl = gl;
    this.target = target;
    this.type = type;
    this.array = new type(0);
    this.buffer = gl.createBuffer();
  }

  /** Reserves so many numbers. True if everything has to be written again. */
  reserve(length) {
    if (length <= this.array.length) return false;
    this.array = new this.type(Math.max(length, 2 * this.array.length, 1024));
    this.gl.bindBuffer(this.target, this.buffer);
    this.gl.bufferData(this.target, this.array.byteLength, this.gl.DYNAMIC_DRAW);
    return true;
  }

  /** Uploads a range of the array to the buffer, which must be bound. */
  write(from, to) {
    if (to > from) this.gl.bufferSubData(this.target, from * 4, this.array, from, to - from);
  }

  bind() {
    this.gl.bindBuffer(this.target, this.buffer);
  }
}

/** A texture of strips, and the array that is uploaded to it. */
export class StripTexture {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.array = new Float32Array(0);
    this.texture = gl.createTexture();
    this.bind();
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    const rows = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    /** The most strips that the texture can hold. */
    this.capacity = (Math.min(rows, 4096) * TEXELS) / 2;
  }

  bind() {
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
  }

  /** Reserves so many strips, or `capacity` if that is less. */
  reserve(strips) {
    const { gl } = this;
    const rows = Math.ceil((2 * Math.min(strips, this.capacity)) / TEXELS);
    if (rows * TEXELS * 4 <= this.array.length) return;
    const grown = Math.min(this.capacity / (TEXELS / 2), Math.max(rows, (2 * this.array.length) / (4 * TEXELS)));
    this.array = new Float32Array(grown * TEXELS * 4);
    this.bind();
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, TEXELS, grown, 0, gl.RGBA, gl.FLOAT, null);
  }

  /** Uploads the first strips of the array to the texture. */
  write(strips) {
    const { gl } = this;
    this.bind();
    const rows = Math.ceil((2 * strips) / TEXELS);
    if (rows > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, TEXELS, rows, gl.RGBA, gl.FLOAT, this.array);
  }
}
