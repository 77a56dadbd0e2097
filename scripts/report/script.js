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
  const one = target.closest(".case") || target;
  one.hidden = false;
  if (one.closest(".group")) one.closest(".group").hidden = false;
  for (const inner of [one.querySelector("details"), target.closest("details")]) if (inner) inner.open = true;
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
addEventListener("pointermove", (event) => {
  const figure = event.target.closest && event.target.closest("svg[data-hints]");
  hint.hidden = true;
  if (!figure) return;
  const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(figure.getScreenCTM().inverse());
  let nearest = null;
  for (const point of hints(figure)) {
    const far = Math.hypot(point.x - place.x, point.y - place.y);
    if (far < 120 && (!nearest || far < nearest.far)) nearest = { far, text: point.text };
  }
  if (!nearest) return;
  hint.textContent = nearest.text;
  hint.hidden = false;
  hint.style.left = `${Math.min(event.pageX + 14, scrollX + innerWidth - hint.offsetWidth - 8)}px`;
  hint.style.top = `${event.pageY + 16}px`;
});
