"use strict";
(() => {
  const given = JSON.parse(document.getElementById("given").textContent);
  const by = (id) => document.getElementById(id);
  const form = by("controls");
  let fixed = {}, root = null, asked = null, told = null, busy = 0, waiting = null, pause = 0, grey = 0;
  let record = "replace"; // what becomes of the address with the next scene that stands still
  const times = (window.slipfrontTimes = []); // from move to picture [ms]
  const STILL = 250; // after which a slider has stopped [ms]
  const BEHIND = 500; // after which a field that is late is grey [ms]
  const TITLES = {
    "particle speed": "Particle speed / V₀ in both bodies",
    displacement: "Displacement / (V₀ T) in both bodies",
  };
  const MOMENT = ["time", "picture"]; // names in the address that are no part of a scene
  let said = 0, refused = false;
  const LOST = 5000; // after which an answer is not waited for any more [ms]

  // values of controls, and the ranges, steps and units of sliders for them
  function show({ values, sliders, message, moment }) {
    fixed = values;
    by("message").textContent = message;
    by("share").value = by("share-value").value = moment.share;
    by("of").value = moment.of;
    by("h-body").textContent = TITLES[moment.of];
    for (const { name, label, unit, low, high, step } of sliders) {
      const slider = by(name);
      Object.assign(slider, { min: low, max: high, step });
      const text = unit ? `${label} [${unit}]` : label;
      slider.labels[0].textContent = text;
      by(name + "-value").labels[0].textContent = text + ", as a number";
    }
    for (const [name, value] of Object.entries(values))
      if (by(name) && form.contains(by(name))) by(name).value = value;
    label();
  }

  // what the address of a scene adds where its pictures show another moment or quantity
  function moment() {
    const all = new URLSearchParams(location.search);
    return MOMENT.filter((key) => all.has(key)).map((key) => `&${key}=${all.get(key)}`).join("");
  }

  // values of controls; a number that no slider can hit is kept as it was given
  function values() {
    const all = { ...fixed };
    for (const control of form.querySelectorAll("select[name]")) all[control.name] = control.value;
    return all;
  }

  // takes over what a slider or the box beside it says; whether that is a number
  function take(control) {
    if (control.value === "" || !Number.isFinite(+control.value)) return false;
    fixed[control.dataset.of || control.name] = +control.value;
    if (control.dataset.of) by(control.dataset.of).value = control.value;
    return true;
  }

  function label() {
    const all = values();
    for (const control of form.querySelectorAll("input[type=range][name]")) {
      const text = String(+(+all[control.name]).toPrecision(6));
      const box = by(control.name + "-value");
      if (box !== document.activeElement) box.value = text;
      control.setAttribute("aria-valuetext", text);
    }
    const shown = {};
    for (const [choice, kinds] of Object.entries(given.shown))
      for (const [kind, names] of Object.entries(kinds))
        for (const name of names) shown[name] = shown[name] || all[choice] === kind;
    for (const [name, is] of Object.entries(shown))
      form.querySelector(`[data-name=${name}]`).toggleAttribute("data-hidden", !is);
  }

  function send(message) { asked.value = JSON.stringify({ ...message, at: performance.now() }); }

  // one question at a time: what moves meanwhile is asked together when the answer is there
  function ask(moving) {
    label();
    const moment = { share: +by("share").value, of: by("of").value };
    waiting = { values: values(), moving, since: performance.now(), ...moment };
    if (!busy || performance.now() - busy > LOST) next();
  }
  function next() {
    busy = waiting ? performance.now() : 0;
    if (waiting) send(waiting);
    waiting = null;
  }

  function words(news) {
    if ("message" in news) by("message").textContent = news.message;
    if ("status" in news) {
      // an answer takes back the refusal of a scene before it, which may come after the move
      if (refused && !("message" in news)) by("message").textContent = "";
      refused = "message" in news;
      const error = "error" in news ? `, error estimate ${news.error}` : "";
      const time = "solved" in news ? `, solved in ${news.solved.toFixed(0)} ms` : "";
      by("status").textContent = news.status + error + time;
    }
    if ("stale" in news || "status" in news)
      by("pictures").classList.toggle("stale", Boolean(news.stale));
    if ("progress" in news || "since" in news) {
      by("progress").value = news.progress || 0;
      by("progress").hidden = !("progress" in news) || news.progress >= 1;
    }
    if ("program" in news) by("program").textContent = news.program;
    for (const list of ["readings", "scales"])
      if (list in news)
        by(list).replaceChildren(...news[list].flatMap(([name, value]) => {
          const [term, text] = [document.createElement("dt"), document.createElement("dd")];
          term.textContent = name; text.textContent = value;
          return [term, text];
        }));
    by("measures").hidden = !by("scales").children.length;
    if ("since" in news || "field" in news) late(!news.field);
    if ("map" in news) by("map-words").textContent = news.map;
    if ("regimes" in news)
      key("regimes", "--colour", news.regimes.map(({ name, colour }) => [name, colour]));
  }

  // whether the field is that of an earlier scene; it turns grey if it stays so
  function late(is) {
    const pictures = by("pictures");
    pictures.dataset.late = is;
    clearTimeout(grey);
    if (is) grey = setTimeout(() => pictures.classList.add("behind"), BEHIND);
    else pictures.classList.remove("behind");
  }

  function save({ name, mime, content }) {
    const bytes = Uint8Array.from(atob(content), (c) => c.charCodeAt(0));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([bytes], { type: mime }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
  }

  // a slider that moves leaves the address alone; where it stops is a step of the history
  function keep(query) {
    name(query);
    if (query === location.search) return;
    if (record === "push") history.pushState(null, "", query);
    else history.replaceState(null, "", query);
    record = "push";
  }

  // the menu names the scene while it is that of the name
  function name(query) {
    const plain = (text) => JSON.stringify([...new URLSearchParams(text)]
      .filter(([key]) => !MOMENT.includes(key))
      .map(([key, value]) => [key, value !== "" && Number.isFinite(+value) ? +value : value]).sort());
    const known = [...by("scenes").options].find((one) => plain(one.value) === plain(query));
    by("scenes").value = known ? known.value : "";
  }

  // numbers of pictures, by the model that shows them; null stands for no number
  function draw(models) {
    const holes = (one) => (Array.isArray(one) ? one.map(holes) : one === null ? NaN : one);
    for (const [id, properties] of Object.entries(models)) {
      if ("data" in properties)
        for (const [name, column] of Object.entries(properties.data))
          properties.data[name] = holes(column);
      root.get_model_by_id(id).setv(properties, { sync: false });
    }
  }

  // words wait until pictures are painted, which else lay out the page for each of them
  function hear() {
    const news = JSON.parse(told.value);
    draw(news.models);
    requestAnimationFrame(() => {
      words(news);
      if ("since" in news) setTimeout(() => times.push(performance.now() - news.since));
    });
    if ("values" in news) { show(news); ask(false); }
    if ("file" in news) save(news.file);
    if ("query" in news) (news.moving ? name : keep)(news.query);
    if ("since" in news) next();
  }

  function moved(event) {
    const control = event.target;
    if (control.id === "scenes") return;
    if (control.id === "share") by("share-value").value = control.value;
    else if (control.id === "share-value") by("share").value = control.value;
    else if (control.type === "range" || control.dataset.of) if (!take(control)) return;
    if (control.id === "of") by("h-body").textContent = TITLES[control.value];
    clearTimeout(pause);
    by("message").textContent = "";
    const moves = control.type === "range" || control.type === "number";
    if (control.type === "range") ask(true);
    pause = setTimeout(() => ask(false), moves ? STILL : 0);
  }

  // says for a while whether the address is in the clipboard
  async function copy() {
    try {
      await navigator.clipboard.writeText(location.href);
      by("copied").textContent = "copied";
    } catch {
      by("copied").textContent = "not copied; take it from the address bar";
    }
    clearTimeout(said);
    said = setTimeout(() => { by("copied").textContent = ""; }, 4000);
  }

  // what colours and dashes stand for, beside the pictures
  function key(id, property, meanings) {
    by(id).replaceChildren(...meanings.map(([name, look]) => {
      const one = document.createElement("span");
      one.textContent = name; one.style.setProperty(property, look);
      return one;
    }));
  }

  function start(documents) {
    [root] = documents;
    [asked, told] = ["asked", "told"].map((name) => root.get_model_by_name(name));
    told.properties.value.change.connect(hear);
    form.addEventListener("input", moved);
    form.addEventListener("submit", (event) => event.preventDefault());
    by("scenes").addEventListener("change", (event) => {
      if (event.target.value) send({ query: event.target.value + moment() });
    });
    form.addEventListener("change", (event) => {
      if (event.target.id === "share-value") event.target.value = by("share").value;
    });
    form.addEventListener("focusout", label); // a box without a number shows the old one again
    for (const button of form.querySelectorAll("[data-file]"))
      button.addEventListener("click", () => send({ file: button.dataset.file }));
    by("link").addEventListener("click", copy);
    addEventListener("popstate", () => {
      record = "replace";
      send({ query: location.search });
    });
    key("kinds", "--colour", given.kinds);
    key("curves", "--line", given.curves);
    show(given);
    ask(false);
  }

  Bokeh.embed.embed_items({}, JSON.parse(by("documents").textContent));
  const wait = setInterval(() => {
    const documents = Bokeh.documents;
    if (documents.length && documents[0].get_model_by_name("told")) {
      clearInterval(wait);
      start(documents);
    }
  }, 20);
})();
