// The page works without this: it filters, opens what is linked to, and shows the values of points.
"use strict";
const filter = document.getElementById("filter");
const search = document.getElementById("search");
const cases = [...document.querySelectorAll(".case")];
const words = new Map(cases.map((one) => [one, `${one.id} ${one.querySelector("summary").textContent} ${one.dataset.topics}`.toLowerCase()]));

function show() {
  const asked = search.value.toLowerCase().split(/\s+/);
  const verdict = document.getElementById("by-verdict").value;
  const topic = document.getElementById("by-topic").value;
  let count = 0;
  for (const one of cases) {
    const fits = asked.every((word) => words.get(one).includes(word))
      && (!verdict || one.dataset.verdict.split(" ").includes(verdict))
      && (!topic || one.dataset.topics.split(" ").includes(topic));
    one.hidden = !fits;
    count += fits;
  }
  for (const group of document.querySelectorAll(".group")) group.hidden = !group.querySelector(".case:not([hidden])");
  document.getElementById("shown").value = `${count} of ${cases.length} cases`;
}
if (filter) { // a report of few cases has none
  filter.hidden = false;
  filter.addEventListener("input", show);
  filter.addEventListener("submit", (event) => event.preventDefault());
  show();
}

// A link to a case, or to anything within it, opens it.
function open() {
  const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  const one = target.closest(".case");
  if (one) {
    one.hidden = one.closest(".group").hidden = false;
    one.querySelector("details").open = true;
  }
  if (target.closest("details")) target.closest("details").open = true;
  target.scrollIntoView();
}
addEventListener("hashchange", open);
open();

// On a narrow page the index is above the answer: it starts closed.
if (matchMedia("(max-width: 68rem)").matches) document.getElementById("contents").open = false;

const theme = document.getElementById("theme");
theme.hidden = false;
theme.addEventListener("click", () => {
  const dark = getComputedStyle(document.documentElement).colorScheme === "dark"
    || (!document.documentElement.dataset.theme && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.dataset.theme = dark ? "light" : "dark";
});

if (filter) addEventListener("keydown", (event) => {
  if (event.target.matches("input, select, textarea")) {
    if (event.key === "Escape") { search.value = ""; show(); event.target.blur(); }
  } else if (event.key === "/" && !event.ctrlKey && !event.metaKey && !event.altKey) {
    event.preventDefault();
    search.focus();
  }
});

// All is opened for print, and closed again.
let closed = [];
addEventListener("beforeprint", () => {
  closed = [...document.querySelectorAll("details:not([open])")];
  for (const one of closed) one.open = true;
});
addEventListener("afterprint", () => closed.forEach((one) => { one.open = false; }));

// The value of the point nearest to the pointer.
const hint = document.getElementById("hint");
function hints(figure) {
  let before = [];  // a word that is left out is that of the text before
  figure.points ??= figure.dataset.hints.split("\n").map((line) => {
    const [x, y, ...text] = line.split(",");
    before = text.join(",").split(" ").map((word, index) => word || before[index]);
    return { x: +x, y: +y, text: before.join(" ") };
  });
  return figure.points;
}
function place(event, figure) {
  return new DOMPoint(event.clientX, event.clientY).matrixTransform(figure.getScreenCTM().inverse());
}
addEventListener("pointermove", (event) => {
  const figure = event.target.closest && event.target.closest("svg[data-hints]");
  hint.hidden = true;
  if (!figure) return;
  const at = place(event, figure);
  let nearest = null;
  for (const point of hints(figure)) {
    const far = Math.hypot(point.x - at.x, point.y - at.y) / (figure.magnified || 1);
    if (far < 120 && (!nearest || far < nearest.far)) nearest = { far, text: point.text };
  }
  if (!nearest) return;
  hint.textContent = nearest.text;
  hint.hidden = false;
  hint.style.left = `${Math.min(event.pageX + 14, scrollX + innerWidth - hint.offsetWidth - 8)}px`;
  hint.style.top = `${event.pageY + 16}px`;
});

// A figure with values can be enlarged: wheel, + and - zoom, dragging moves, arrows go from value to value.
const zoom = document.getElementById("zoom");
const told = zoom.querySelector("output");
let enlarged, whole, view, onPage, current; // onPage: its width there
function look(x, y, width) {
  const height = width * whole.height / whole.width;
  view = { x: Math.max(0, Math.min(x, whole.width - width)), y: Math.max(0, Math.min(y, whole.height - height)), width, height };
  enlarged.setAttribute("viewBox", `${view.x} ${view.y} ${width} ${height}`);
  enlarged.magnified = width / whole.width;
  enlarged.style.setProperty("--part", enlarged.magnified * onPage / enlarged.clientWidth); // lines and letters stay as they are
}
function magnify(by, at = { x: view.x + view.width / 2, y: view.y + view.height / 2 }) {
  const width = Math.min(whole.width, Math.max(whole.width / 50, view.width / by));
  look(at.x - (at.x - view.x) * width / view.width, at.y - (at.y - view.y) * width / view.width, width);
}
function step(by) {
  const points = hints(enlarged);
  current = (current + by + points.length) % points.length;
  const { x, y, text } = points[current];
  told.value = text;
  if (x < view.x || x > view.x + view.width || y < view.y || y > view.y + view.height) look(x - view.width / 2, y - view.height / 2, view.width);
  const ring = enlarged.querySelector("circle") || enlarged.appendChild(document.createElementNS(enlarged.namespaceURI, "circle"));
  ring.setAttribute("cx", x);
  ring.setAttribute("cy", y);
}
for (const figure of document.querySelectorAll("svg[data-hints]")) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "enlarge";
  button.textContent = "Enlarge";
  button.setAttribute("aria-label", `Enlarge: ${figure.getAttribute("aria-label").split(/[.:;]/)[0]}`);
  figure.after(button);
  button.addEventListener("click", () => {
    enlarged = figure.cloneNode(true);
    enlarged.removeAttribute("id");
    zoom.querySelector("div").replaceChildren(enlarged);
    whole = figure.viewBox.baseVal;
    onPage = 1.2 * figure.clientWidth;
    current = -1;
    told.value = "";
    zoom.append(hint);
    zoom.showModal();
    look(0, 0, whole.width);
  });
}
zoom.addEventListener("close", () => document.body.append(hint));
zoom.addEventListener("click", (event) => {
  const by = event.target.dataset.by;
  if (by === "close") zoom.close();
  else if (by) magnify(+by);
});
zoom.addEventListener("keydown", (event) => {
  const does = { "+": () => magnify(1.5), "-": () => magnify(1 / 1.5), "0": () => magnify(0), ArrowRight: () => step(1), ArrowLeft: () => step(-1) }[event.key];
  if (!does || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  does();
});
zoom.addEventListener("wheel", (event) => {
  event.preventDefault();
  magnify(event.deltaY < 0 ? 1.2 : 1 / 1.2, place(event, enlarged));
}, { passive: false });
zoom.addEventListener("pointermove", (event) => {
  if (!event.buttons || !event.target.closest("svg")) return;
  const pixel = view.width / enlarged.clientWidth;
  look(view.x - event.movementX * pixel, view.y - event.movementY * pixel, view.width);
});
