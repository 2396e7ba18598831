// Drawing with WebGL2.

const VERTEX_SHADER = `#version 300 es
uniform mat4 view, projection;
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 direction;
layout(location = 2) in float measured;
out vec3 normal, eye;
out float value;
void main() {
  vec4 seen = view * vec4(place, 1.0);
  normal = mat3(view) * direction;
  eye = -seen.xyz;
  value = measured;
  gl_Position = projection * seen;
}`;

// A hemisphere of sky and ground, a key light from the upper left, a fill, a rim from behind; the
// gamma of 2 for 2.2 spares software its powers.
const FRAGMENT_SHADER = `#version 300 es
precision highp float;
uniform int style; // 0 lit, 1 ghost, 2 lines
uniform vec3 colour, stops[5];
uniform float limit;
in vec3 normal, eye;
in float value;
out vec4 shown;
vec3 base() {
  if (limit <= 0.0) return colour;
  float at = (clamp(value / limit, -1.0, 1.0) + 1.0) * 2.0;
  int k = min(int(at), 3);
  return mix(stops[k], stops[k + 1], at - float(k));
}
void main() {
  vec3 n = normalize(normal), v = normalize(eye);
  float edge = 1.0 - abs(dot(n, v));
  if (style == 2) { shown = vec4(colour, 1.0) * 0.42; return; }
  if (style == 1) { shown = vec4(colour, 1.0) * (0.16 + 0.6 * edge * edge); return; }
  vec3 key = normalize(vec3(-0.5, 0.62, 0.6));
  vec3 light = mix(vec3(0.13, 0.12, 0.12), vec3(0.34, 0.37, 0.42), 0.5 + 0.5 * n.y);
  light += vec3(0.92, 0.88, 0.82) * max(dot(n, key), 0.0);
  light += vec3(0.16, 0.15, 0.16) * max(dot(n, normalize(vec3(0.85, -0.05, 0.5))), 0.0);
  float rim = edge * edge * edge * smoothstep(-0.5, 0.9, n.y + 0.5 * n.x);
  vec3 lit = base();
  lit *= lit * (limit > 0.0 ? mix(light, vec3(0.85), 0.4) : light);
  if (limit <= 0.0) {
    float gloss = max(dot(n, normalize(key + v)), 0.0);
    for (int k = 0; k < 5; k++) gloss *= gloss;
    lit += vec3(0.26, 0.29, 0.33) * rim + 0.05 * gloss;
  }
  shown = vec4(sqrt(lit), 1.0);
}`;

/** Whether software draws: then smooth edges and fine grids would keep a hand waiting. */
function drawsBySoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const named = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

class GlRenderer {
  kind = 'webgl2';

  constructor(canvas) {
    this.slow = drawsBySoftware();
    this.gl = canvas.getContext('webgl2', { antialias: !this.slow });
    if (!this.gl) throw new Error('no WebGL2');
    this.restore();
  }

  /** Makes everything that the context holds; again when it was lost. */
  restore() {
    const { gl } = this;
    this.arrays = new WeakMap();
    this.indices = new WeakMap();
    const program = gl.createProgram();
    for (const [kind, source] of
      [[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    this.uniform = (name) => gl.getUniformLocation(program, name);
    gl.uniform3fv(this.uniform('stops'), ERROR_STOPS.flat());
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.polygonOffset(1, 2);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  draw(views, width, height) {
    const { gl } = this;
    for (const view of views) {
      const box = [view.x * width, (1 - view.y - view.height) * height,
        view.width * width, view.height * height].map(Math.round);
      gl.viewport(...box);
      gl.scissor(...box);
      gl.clearColor(0, 0, 0, 0);
      gl.depthMask(true);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      const { view: seen, projection } = matrices(view.frame, box[2] / box[3]);
      gl.uniformMatrix4fv(this.uniform('view'), false, seen);
      gl.uniformMatrix4fv(this.uniform('projection'), false, projection);
      for (const item of view.items) this.drawItem(item);
    }
  }

  drawItem({ surface: { lines, triangles }, surface: drawnOne, style, colour, limit = 0 }) {
    const { gl } = this;
    const kind = { lit: 0, ghost: 1, lines: 2 }[style];
    const indices = style === 'lines' ? lines : triangles;
    const toggle = (on, what) => (on ? gl.enable(what) : gl.disable(what));
    toggle(style !== 'lit', gl.BLEND);
    toggle(style === 'ghost', gl.CULL_FACE);
    toggle(style === 'lit', gl.POLYGON_OFFSET_FILL);
    gl.depthMask(style === 'lit');
    gl.uniform1i(this.uniform('style'), kind);
    gl.uniform3fv(this.uniform('colour'), colour);
    gl.uniform1f(this.uniform('limit'), limit);
    this.bindVertices(drawnOne);
    this.bindIndices(indices);
    const mode = style === 'lines' ? gl.LINES : gl.TRIANGLES;
    gl.drawElements(mode, indices.length, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  /** Binds the vertices of a surface and sends them when they have changed. */
  bindVertices(drawnOne) {
    const { gl } = this;
    const known = this.arrays.get(drawnOne);
    const held = known ?? { array: gl.createVertexArray(), buffer: gl.createBuffer() };
    gl.bindVertexArray(held.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, held.buffer);
    if (!known) {
      gl.bufferData(gl.ARRAY_BUFFER, drawnOne.vertices, gl.DYNAMIC_DRAW);
      [[3, 0], [3, 12], [1, 24]].forEach(([size, offset], k) => {
        gl.enableVertexAttribArray(k);
        gl.vertexAttribPointer(k, size, gl.FLOAT, false, STRIDE * 4, offset);
      });
      this.arrays.set(drawnOne, held);
    } else if (held.version !== drawnOne.version) {
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, drawnOne.vertices);
    }
    held.version = drawnOne.version;
  }

  bindIndices(indices) {
    const { gl } = this;
    const known = this.indices.get(indices);
    const buffer = known ?? gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    if (known) return;
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    this.indices.set(indices, buffer);
  }

  /** Waits until what was drawn is there. */
  finish() {
    const pixel = new Uint8Array(4);
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, pixel);
  }
}
