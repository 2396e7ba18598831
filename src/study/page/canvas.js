// Drawing without WebGL2: triangles with a buffer of depths, shaded at their vertices.

class CanvasRenderer {
  kind = 'canvas';
  slow = true;

  constructor(canvas) {
    this.context = canvas.getContext('2d');
  }

  draw(views, width, height) {
    this.context.clearRect(0, 0, width, height);
    for (const view of views) {
      const [w, h] = [Math.round(view.width * width), Math.round(view.height * height)];
      if (w < 1 || h < 1) continue;
      const image = this.context.createImageData(w, h);
      const depths = new Float32Array(w * h).fill(-Infinity);
      for (const item of view.items)
        if (item.style === 'lit') this.drawSurface(item, view.frame, image, depths);
      this.context.putImageData(image, Math.round(view.x * width), Math.round(view.y * height));
    }
  }

  drawSurface({ surface: { vertices, triangles }, colour, limit }, frame, image, depths) {
    const count = vertices.length / STRIDE;
    const { view, projection } = matrices(frame, image.width / image.height);
    const corners = new Float32Array(count * 6); // x, y and depth on the screen; colour
    for (let v = 0; v < count; v++) {
      const [px, py, pz, nx, ny, nz, value] = vertices.subarray(v * STRIDE, (v + 1) * STRIDE);
      const along = (row, x, y, z) => view[row] * x + view[4 + row] * y + view[8 + row] * z;
      const depth = along(2, px, py, pz) + view[14];
      const x = (projection[0] * (along(0, px, py, pz) + view[12])) / -depth;
      const y = (projection[5] * (along(1, px, py, pz) + view[13])) / -depth;
      const normal = [0, 1, 2].map((row) => along(row, nx, ny, nz));
      corners.set([(x + 1) * 0.5 * image.width, (1 - y) * 0.5 * image.height, depth], v * 6);
      corners.set(shade(normal, limit > 0 ? errorColour(value, limit) : colour), v * 6 + 3);
    }
    for (let t = 0; t < triangles.length; t += 3)
      fillTriangle(corners, triangles[t] * 6, triangles[t + 1] * 6, triangles[t + 2] * 6,
        image, depths);
  }

  finish() {}
}

/** The light of the shader above without rim and gloss, at one vertex. */
function shade([x, y, z], colour) {
  const key = Math.max(-0.5 * x + 0.62 * y + 0.6 * z, 0);
  const sky = 0.5 + 0.5 * y;
  return colour.map((c, k) => {
    const light = 0.12 + [0.21, 0.25, 0.3][k] * sky + [0.92, 0.88, 0.82][k] * key;
    return 255 * c * Math.sqrt(light);
  });
}

function fillTriangle(corners, a, b, c, { data: pixels, width, height }, depths) {
  const [ax, ay, bx, by] = [corners[a], corners[a + 1], corners[b], corners[b + 1]];
  const [cx, cy] = [corners[c], corners[c + 1]];
  const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  if (!(Math.abs(area) > 1e-9) || Math.max(corners[a + 2], corners[b + 2], corners[c + 2]) >= 0)
    return;
  const [left, right] = [Math.max(Math.floor(Math.min(ax, bx, cx)), 0),
    Math.min(Math.ceil(Math.max(ax, bx, cx)), width - 1)];
  const [top, bottom] = [Math.max(Math.floor(Math.min(ay, by, cy)), 0),
    Math.min(Math.ceil(Math.max(ay, by, cy)), height - 1)];
  for (let y = top; y <= bottom; y++) {
    for (let x = left; x <= right; x++) {
      const v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area;
      const w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area;
      const u = 1 - v - w;
      if (u < -1e-6 || v < -1e-6 || w < -1e-6) continue;
      const at = y * width + x;
      const depth = u * corners[a + 2] + v * corners[b + 2] + w * corners[c + 2];
      if (depth <= depths[at]) continue;
      depths[at] = depth;
      for (let k = 3; k < 6; k++)
        pixels[4 * at + k - 3] = u * corners[a + k] + v * corners[b + k] + w * corners[c + k];
      pixels[4 * at + 3] = 255;
    }
  }
}
