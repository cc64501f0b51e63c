// The controls: from inputs to what is shown, and back.

const labelOf = (image) => image.label;

/** The controls of a page; `state` is what is shown, and `onChange` is told when it changes. */
class Controls {
  constructor(data, state, { onChange }) {
    this.data = data;
    this.state = state;
    this.onChange = onChange;
    this.fillMaps();
    this.fillChannels();
    this.fillEnds();
    this.bindExposure();
    this.bindAnalyzer();
    this.bindKeys();
    this.show();
  }

  set(changes) {
    Object.assign(this.state, changes);
    this.show();
    this.onChange();
  }

  fillMaps() {
    const select = element("map");
    const groups = new Map();
    for (const map of this.data.maps) {
      if (!groups.has(map.group)) groups.set(map.group, make("optgroup", { label: map.group }));
      groups.get(map.group).append(make("option", { value: map.id, textContent: map.title }));
    }
    select.append(...groups.values());
    select.addEventListener("change", () => {
      this.set({ map: this.data.maps.find((map) => map.id === select.value) });
    });
  }

  fillChannels() {
    const most = this.data.images.find((image) => image.channels.length > 1);
    this.bindBand(most?.bands);
    if (!most) {
      element("channel-row").remove();
      return;
    }
    const select = element("channel");
    const all = make("option", { value: "", textContent: this.wordsOfAll(most) });
    const rest = most.channels.map((name, index) => {
      const textContent = most.bands ? bandName(most, index) : name;
      return make("option", { value: String(index), textContent });
    });
    select.append(all, ...rest);
    select.addEventListener("change", () => {
      this.set({ channel: select.value === "" ? null : Number(select.value) });
    });
  }

  wordsOfAll({ bands, weights }) {
    if (!bands) return "All (maps: luminance)";
    return weights ? "All, in color (maps: mean)" : "All, their mean";
  }

  /** The slider of bands. */
  bindBand(bands) {
    this.bands = bands;
    if (!bands) {
      element("band-row").remove();
      return;
    }
    const slider = element("band");
    slider.max = String(bands.length - 1);
    slider.addEventListener("input", () => this.set({ channel: slider.valueAsNumber }));
  }

  showBand(channel) {
    const { bands } = this;
    const [slider, words] = [element("band"), element("band-words")];
    slider.value = String(channel ?? (bands.length - 1) >> 1);
    slider.setAttribute("aria-valuetext", channel === null ? "all" : bandWords(bands[channel]));
    words.textContent = channel === null ? "all" : `${threeOrMore(bands[channel].center_nm)} nm`;
    element("band-row").classList.toggle("idle", channel === null);
  }

  fillEnds() {
    const select = element("end");
    select.append(...this.data.ends.map((end, index) => {
      const share = threeDigits(Math.fround(end));
      const fits = index === this.data.end ? ", fits the image" : "";
      return make("option", { value: String(index), textContent: share + fits });
    }));
    select.addEventListener("change", () => this.set({ end: Number(select.value) }));
  }

  /** A slider and a number beside it that are one value. */
  bindPair(slider, number, change) {
    const [first, second] = [element(slider), element(number)];
    for (const input of [first, second]) {
      input.addEventListener("input", () => {
        const value = input.valueAsNumber;
        if (Number.isFinite(value)) change(value);
      });
    }
    // An empty number takes the value again when it is left.
    second.addEventListener("change", () => this.show());
  }

  bindExposure() {
    this.bindPair("exposure", "exposure-number", (exposure) => {
      this.set({ exposure: Math.max(-100, Math.min(100, exposure)) });
    });
  }

  bindAnalyzer() {
    const section = element("analyzer");
    const polarized = this.data.images.filter(isPolarized);
    if (polarized.length < this.data.images.length) {
      element("no-polarization").hidden = false;
      element("no-polarization").textContent = this.wordsWithoutPolarization(polarized.length);
    }
    if (polarized.length === 0) {
      section.remove();
      return;
    }
    this.radios = [...section.querySelectorAll("input[type=radio]")];
    const intensity = this.data.maps.find((map) => map.quantity === "intensity");
    // Behind an analyzer there is one polarization, which no map need show.
    for (const radio of this.radios) {
      radio.addEventListener("change", () => this.set({ analyzer: radio.value, map: intensity }));
    }
    this.bindPair("angle", "angle-number", (angle) => {
      this.set({ analyzer: "linear", angle, map: intensity });
    });
  }

  wordsWithoutPolarization(polarized) {
    const { images } = this.data;
    const without = images.filter((image) => !isPolarized(image));
    const rendered = "An image rendered with --mode polarized has all four components.";
    if (polarized === 0 && images.length === 1) {
      return `This image holds the intensity S0 alone: there is no polarization in it to show or `
        + `analyze. ${rendered}`;
    }
    const names = polarized === 0 ? "Both images hold" : `${without[0].label} holds`;
    return `${names} the intensity S0 alone; where polarization is shown, it is grey. ${rendered}`;
  }

  bindKeys() {
    const focus = {
      m: () => element("map"), e: () => element("exposure"), b: () => element("band"),
    };
    focus.a = () => this.radios?.find((radio) => radio.checked);
    document.addEventListener("keydown", (event) => {
      const typing = event.target.matches("select, input[type=number]");
      if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
      const target = focus[event.key.toLowerCase()]?.();
      if (!target) return;
      target.focus();
      event.preventDefault();
    });
  }

  /** Shows the state in the inputs. */
  show() {
    const { map, channel, end, exposure, analyzer, angle } = this.state;
    element("map").value = map.id;
    if (element("channel")) element("channel").value = channel === null ? "" : String(channel);
    if (this.bands) this.showBand(channel);
    element("end").value = String(end);
    element("end-row").hidden = map.legends.length < 2;
    element("exposure-row").hidden = map.quantity !== "intensity";
    this.showPair("exposure", "exposure-number", exposure);
    if (!this.radios) return;
    for (const radio of this.radios) radio.checked = radio.value === analyzer;
    this.showPair("angle", "angle-number", angle);
    element("angle-row").classList.toggle("idle", analyzer !== "linear");
    element("dial-axis").setAttribute("transform", `rotate(${-angle})`);
  }

  showPair(slider, number, value) {
    element(slider).value = String(value);
    const box = element(number);
    if (document.activeElement !== box || box.valueAsNumber !== value) box.value = String(value);
  }
}
