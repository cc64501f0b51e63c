// The stage: the images on a canvas, zoomed and moved, with the divider and the pixel under the
// pointer. Lengths are in pixels of the screen unless they are said to be of the image.

const ZOOM_MAX = 256;
/** A whole image is enlarged no further than this by itself. */
const FIT_MAX = 64;
/** A press that moves less than this is a click. */
const CLICK_MAX = 4;

class Stage {
  /**
   * `onPixel` is told the pixel [x, y] of the image that is pointed at; `painterFor` gives what
   * colors the pixels of an image as they are to be shown now.
   */
  constructor(images, { painterFor, onPixel }) {
    this.images = images;
    this.painterFor = painterFor;
    this.onPixel = onPixel;
    this.size = [images[0].width, images[0].height];
    this.canvas = document.getElementById("picture");
    this.context = this.canvas.getContext("2d");
    this.divider = document.getElementById("divider");
    this.marker = document.getElementById("marker");
    this.sheets = images.map(() => ({ canvas: document.createElement("canvas"), key: "" }));
    this.version = 0;
    this.zoom = 1;
    this.corner = [0, 0];
    this.fits = true;
    this.share = 0.5;
    this.pixel = null;
    this.held = false;
    this.listen();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
  }

  listen() {
    const { canvas, divider } = this;
    canvas.addEventListener("pointermove", (event) => this.pointed(event));
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 0 ? event.deltaY / 100 : event.deltaY / 3;
      this.zoomBy(1.25 ** -lines, this.positionOf(event));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.typed(event));
    divider.addEventListener("pointerdown", (event) => {
      divider.setPointerCapture(event.pointerId);
      event.preventDefault();
      divider.focus();
    });
    divider.addEventListener("pointermove", (event) => {
      if (!divider.hasPointerCapture(event.pointerId)) return;
      this.divide(this.positionOf(event)[0] / canvas.width);
    });
    divider.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01 };
      const far = { Home: 0, End: 1 };
      if (event.key in step) this.divide(this.share + step[event.key] * (event.shiftKey ? 10 : 1));
      else if (event.key in far) this.divide(far[event.key]);
      else return;
      event.preventDefault();
    });
  }

  /** Where an event is on the canvas. */
  positionOf(event) {
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.canvas.width / box.width;
    return [(event.clientX - box.left) * ratio, (event.clientY - box.top) * ratio];
  }

  /** The pixel of the image at a place of the canvas, if there is one. */
  pixelAt(position) {
    const pixel = position.map((at, i) => Math.floor((at - this.corner[i]) / this.zoom));
    return pixel.every((at, i) => at >= 0 && at < this.size[i]) ? pixel : null;
  }

  pointed(event) {
    const pixel = this.pixelAt(this.positionOf(event));
    if (pixel && !this.held) this.point(pixel, false);
  }

  /** Points at a pixel; it is marked where it is not under the pointer. */
  point(pixel, marked) {
    this.pixel = pixel;
    this.marked = marked;
    this.placeMarker();
    this.onPixel(pixel);
  }

  press(event) {
    if (event.button !== 0) return;
    const { canvas } = this;
    const start = this.positionOf(event);
    const corner = [...this.corner];
    let moved = false;
    canvas.setPointerCapture(event.pointerId);
    const move = (next) => {
      const shift = this.positionOf(next).map((at, i) => at - start[i]);
      moved ||= Math.hypot(...shift) > CLICK_MAX;
      if (!moved) return;
      this.fits = false;
      this.corner = corner.map((at, i) => Math.round(at + shift[i]));
      this.draw();
    };
    const end = () => {
      canvas.removeEventListener("pointermove", move);
      canvas.removeEventListener("pointerup", up);
      canvas.removeEventListener("pointercancel", end);
    };
    const up = (last) => {
      end();
      const pixel = this.pixelAt(this.positionOf(last));
      if (moved || !pixel) return;
      this.held = !this.held;
      this.point(pixel, this.held);
    };
    canvas.addEventListener("pointermove", move);
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", end);
  }

  typed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const steps = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
    };
    const actions = {
      "+": () => this.zoomBy(2),
      "=": () => this.zoomBy(2),
      "-": () => this.zoomBy(0.5),
      0: () => this.fit(),
      1: () => this.zoomTo(1),
    };
    if (event.key in steps) this.step(steps[event.key], event.shiftKey ? 10 : 1);
    else if (event.key in actions) actions[event.key]();
    else return;
    event.preventDefault();
  }

  /** Moves the pixel that is looked at, which then holds. */
  step(direction, count) {
    const from = this.pixel ?? this.size.map((length) => Math.floor(length / 2));
    const moved = this.pixel ? count : 0;
    const pixel = from.map((at, i) => {
      const to = at + direction[i] * moved;
      return Math.max(0, Math.min(this.size[i] - 1, to));
    });
    this.held = true;
    this.show(pixel);
    this.point(pixel, true);
  }

  /** Moves the image so far that a pixel can be seen. */
  show(pixel) {
    const lengths = [this.canvas.width, this.canvas.height];
    const corner = this.corner.map((at, i) => {
      const from = at + pixel[i] * this.zoom;
      const over = from + this.zoom - lengths[i];
      if (from < 0) return Math.ceil(at - from);
      return over > 0 ? Math.floor(at - over) : at;
    });
    if (corner.every((at, i) => at === this.corner[i])) return;
    this.fits = false;
    this.corner = corner;
    this.draw();
  }

  get middle() {
    return [this.canvas.width / 2, this.canvas.height / 2];
  }

  zoomBy(factor, around = this.middle) {
    this.zoomTo(this.zoom * factor, around);
  }

  /** Zooms to pixels of the screen for a pixel of the image, a whole number if it can be. */
  zoomTo(zoom, around = this.middle) {
    const least = Math.min(this.zoomThatFits() / 4, 1);
    const bounded = Math.max(least, Math.min(ZOOM_MAX, zoom));
    const whole = Math.round(bounded);
    const next = Math.abs(bounded - whole) < 0.02 * whole ? whole : bounded;
    const place = around.map((at, i) => (at - this.corner[i]) / this.zoom);
    this.corner = around.map((at, i) => Math.round(at - place[i] * next));
    this.zoom = next;
    this.fits = false;
    this.draw();
  }

  zoomThatFits() {
    const zoom = Math.min(this.canvas.width / this.size[0], this.canvas.height / this.size[1]);
    return zoom >= 4 ? Math.min(FIT_MAX, Math.floor(zoom)) : zoom;
  }

  /** Shows the whole image. */
  fit() {
    this.fits = true;
    this.zoom = this.zoomThatFits();
    const lengths = [this.canvas.width, this.canvas.height];
    this.corner = lengths.map((at, i) => Math.floor((at - this.zoom * this.size[i]) / 2));
    this.draw();
  }

  resize() {
    const box = this.canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const size = [box.width, box.height].map((length) => Math.max(1, Math.round(length * ratio)));
    if (size[0] === this.canvas.width && size[1] === this.canvas.height) return;
    [this.canvas.width, this.canvas.height] = size;
    if (this.fits) this.fit();
    else this.draw();
  }

  /** Puts the divider at a share of the stage's width. */
  divide(share) {
    this.share = Math.max(0, Math.min(1, share));
    this.draw();
  }

  /** What is shown has changed. */
  change() {
    this.version += 1;
    this.draw();
  }

  /** Draws with the next frame. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    const { canvas, context } = this;
    const two = this.images.length > 1;
    const cut = two ? Math.round(this.share * canvas.width) : canvas.width;
    context.clearRect(0, 0, canvas.width, canvas.height);
    this.drawImage(0, 0, cut);
    if (two) this.drawImage(1, cut, canvas.width);
    this.placeDivider(cut);
    this.placeMarker();
    document.getElementById("zoom").textContent = `${Math.round(100 * this.zoom)}%`;
    Object.assign(canvas.dataset, { left: this.corner[0], top: this.corner[1], zoom: this.zoom });
  }

  /** Draws what an image shows between two columns of the canvas. */
  drawImage(index, from, to) {
    const region = this.regionInSight();
    if (!region || to <= from) return;
    const { context, zoom, corner } = this;
    const sheet = this.painted(index, region);
    const { x, y, columns, rows, step } = region;
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, this.canvas.height);
    context.clip();
    context.beginPath();
    context.rect(corner[0], corner[1], zoom * this.size[0], zoom * this.size[1]);
    context.clip();
    context.imageSmoothingEnabled = zoom < 1;
    context.imageSmoothingQuality = "high";
    context.drawImage(
      sheet, 0, 0, columns, rows,
      corner[0] + x * zoom, corner[1] + y * zoom, columns * step * zoom, rows * step * zoom,
    );
    context.restore();
  }

  /** The part of the image that can be seen, in its pixels, of which every `step`th is drawn. */
  regionInSight() {
    const step = Math.max(1, Math.floor(1 / this.zoom));
    const lengths = [this.canvas.width, this.canvas.height];
    const ranges = this.corner.map((at, i) => {
      const first = Math.max(0, Math.floor(-at / this.zoom));
      const end = Math.min(this.size[i], Math.ceil((lengths[i] - at) / this.zoom));
      const start = first - (first % step);
      return [start, Math.ceil((end - start) / step)];
    });
    const [[x, columns], [y, rows]] = ranges;
    return columns > 0 && rows > 0 ? { x, y, columns, rows, step } : null;
  }

  /** A canvas with a region of an image; what was painted last is kept. */
  painted(index, region) {
    const sheet = this.sheets[index];
    const key = JSON.stringify([this.version, region]);
    if (sheet.key !== key) {
      paintOnto(sheet.canvas, this.images[index], this.painterFor(this.images[index]), region);
      sheet.key = key;
    }
    return sheet.canvas;
  }

  placeDivider(cut) {
    if (this.images.length < 2) return;
    this.divider.hidden = false;
    this.divider.style.left = `${(100 * cut) / this.canvas.width}%`;
    this.divider.setAttribute("aria-valuenow", Math.round(100 * this.share));
  }

  placeMarker() {
    const { marker, pixel, zoom, corner } = this;
    marker.hidden = !(pixel && this.marked);
    if (marker.hidden) return;
    const ratio = this.canvas.width / this.canvas.getBoundingClientRect().width;
    const side = Math.max(zoom / ratio, 7);
    const center = pixel.map((at, i) => (corner[i] + (at + 0.5) * zoom) / ratio);
    marker.style.width = `${side}px`;
    marker.style.height = `${side}px`;
    marker.style.left = `${center[0] - side / 2}px`;
    marker.style.top = `${center[1] - side / 2}px`;
  }
}
