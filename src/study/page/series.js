// Series in the basis of docs/how/conventions.md: packed numbers, sums over degrees and orders.

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new DataView(bytes.buffer);
}

/** Reads little-endian numbers, whatever the order of the machine. */
function numbersOf(base64, Type) {
  const view = bytesOf(base64);
  const size = Type.BYTES_PER_ELEMENT;
  const read = { Uint16Array: 'getUint16', Uint32Array: 'getUint32', Float32Array: 'getFloat32' };
  const numbers = new Type(Math.floor(view.byteLength / size));
  for (let i = 0; i < numbers.length; i++) numbers[i] = view[read[Type.name]](i * size, true);
  return numbers;
}

/**
 * A series of semi-normalised functions with the Condon-Shortley phase. Storage is order by order:
 * for each m the degrees m..lmax, with the factors of the recurrence
 * Q_l = alpha x Q_{l-1} - beta Q_{l-2}.
 */
class Series {
  constructor(lmax, coefficients) {
    const size = ((lmax + 1) * (lmax + 2)) / 2;
    this.lmax = lmax;
    this.cosine = new Float64Array(size);
    this.sine = new Float64Array(size);
    this.alpha = new Float64Array(size);
    this.beta = new Float64Array(size);
    for (let m = 0, at = 0; m <= lmax; m++) {
      for (let l = m; l <= lmax; l++, at++) {
        this.cosine[at] = coefficients[l * l + Math.max(2 * m - 1, 0)];
        this.sine[at] = m > 0 ? coefficients[l * l + 2 * m] : 0;
        const root = Math.sqrt(l * l - m * m);
        this.alpha[at] = (2 * l - 1) / root;
        this.beta[at] = Math.sqrt(Math.max((l - 1) ** 2 - m * m, 0)) / root;
      }
    }
  }

  /** Where the degrees of an order begin. */
  begin(m) {
    return m * (this.lmax + 1) - (m * (m - 1)) / 2;
  }

  /**
   * Sums over degrees on a ring: what multiplies cos m phi and sin m phi in the radius (`a`, `b`)
   * and in its derivative by theta (`da`, `db`), each of at least degree + 2 numbers.
   */
  sumDegrees(degree, theta, { a, b, da, db }) {
    const { cosine, sine, alpha, beta } = this;
    const x = Math.cos(theta);
    const s = Math.sin(theta);
    let first = 1;
    let dFirst = 0;
    for (let m = 0; m <= degree; m++) {
      if (m > 0) {
        const factor = -Math.sqrt((2 * m - 1) / (2 * m));
        dFirst = factor * (x * first + s * dFirst);
        first *= factor * s;
      }
      let at = this.begin(m);
      let [q, dq, last, dLast] = [first, dFirst, 0, 0];
      let [sa, sb, dsa, dsb] = [cosine[at] * q, sine[at] * q, cosine[at] * dq, sine[at] * dq];
      for (let l = m + 1; l <= degree; l++) {
        at++;
        const next = alpha[at] * x * q - beta[at] * last;
        const dNext = alpha[at] * (x * dq - s * q) - beta[at] * dLast;
        last = q;
        dLast = dq;
        q = next;
        dq = dNext;
        sa += cosine[at] * q;
        sb += sine[at] * q;
        dsa += cosine[at] * dq;
        dsb += sine[at] * dq;
      }
      a[m] = sa;
      b[m] = sb;
      da[m] = dsa;
      db[m] = dsb;
    }
    for (const sums of [a, b, da, db]) sums[degree + 1] = 0;
  }

  /** Fills the radii in a direction, cut at each degree from 0 to lmax. */
  radii([x, y, z], out) {
    const { cosine, sine, alpha, beta, lmax } = this;
    const s = Math.hypot(x, y);
    const [cx, sx] = s > 0 ? [x / s, y / s] : [1, 0];
    let [first, cm, sm, at] = [1, 1, 0, 0];
    out.fill(0);
    for (let m = 0; m <= lmax; m++) {
      if (m > 0) {
        first *= -Math.sqrt((2 * m - 1) / (2 * m)) * s;
        [cm, sm] = [cm * cx - sm * sx, cm * sx + sm * cx];
      }
      let [q, last] = [first, 0];
      for (let l = m; l <= lmax; l++, at++) {
        if (l > m) [q, last] = [alpha[at] * z * q - beta[at] * last, q];
        out[l] += (cosine[at] * cm + sine[at] * sm) * q;
      }
    }
    for (let l = 1; l <= lmax; l++) out[l] += out[l - 1];
    return out;
  }

  /** The root mean square over the sphere of the part of each degree. */
  amplitudes() {
    const squares = new Float64Array(this.lmax + 1);
    for (let m = 0, at = 0; m <= this.lmax; m++) {
      for (let l = m; l <= this.lmax; l++, at++) {
        const weight = (m === 0 ? 1 : 0.5) / (2 * l + 1);
        squares[l] += weight * (this.cosine[at] ** 2 + this.sine[at] ** 2);
      }
    }
    return squares.map(Math.sqrt);
  }
}

/**
 * Sums over orders on a ring of n longitudes, n a multiple of 4. Even and odd orders are summed
 * apart: by their signs one sum serves phi, -phi, pi - phi and pi + phi.
 */
function sumOrders(a, b, degree, circle, out) {
  const { cos, sin, n } = circle;
  for (let j = 0; j <= n / 4; j++) {
    let [ce, co, se, so] = [0, 0, 0, 0];
    for (let m = 0, k = 0; m <= degree; m += 2) {
      ce += a[m] * cos[k];
      se += b[m] * sin[k];
      k += j;
      if (k >= n) k -= n;
      co += a[m + 1] * cos[k];
      so += b[m + 1] * sin[k];
      k += j;
      if (k >= n) k -= n;
    }
    out[j] = ce + co + se + so;
    out[(n - j) % n] = ce + co - se - so;
    out[n / 2 - j] = ce - co - se + so;
    out[n / 2 + j] = ce - co + se - so;
  }
}
