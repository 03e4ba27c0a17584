'use strict';
// The page of a flying saw.

page.asked = null;
const charts = new Charts(byId('charts'), {});

// The sliders by their paths: one that is moved keeps its range.
const rows = new Map();
let held;

function change(path, value, gesture) {
  ask('change', { set: [[path, value]] }, gesture);
}

function rowOf(path) {
  if (rows.has(path)) return rows.get(path);
  const label = make('label');
  const slider = make('input', { type: 'range', 'aria-label': `${path} slider` });
  const number = make('input', { type: 'number', step: 'any', 'aria-label': path });
  const out = make('button', { title: 'Leave it out' }, '×');
  slider.addEventListener('input', () => {
    if (held?.path !== path) held = { path, gesture: ++page.gesture };
    change(path, slider.valueAsNumber, held.gesture);
  });
  slider.addEventListener('change', () => {
    held = undefined;
    ask('view');
  });
  number.addEventListener('change', () => change(path, number.value === '' ? null : number.valueAsNumber));
  out.addEventListener('click', () => change(path, null));
  const row = { place: make('div', { className: 'slider' }, label, slider, number, out), label, slider, number, out };
  rows.set(path, row);
  return row;
}

function showSliders(sliders) {
  const places = sliders.map((field) => {
    const row = rowOf(field.path);
    row.label.textContent = field.label;
    if (held?.path !== field.path) {
      row.slider.min = field.is_above_zero ? field.step : field.least;
      row.slider.max = field.most;
      row.slider.step = field.step;
      row.slider.value = field.value ?? 0;
    }
    if (document.activeElement !== row.number) row.number.value = field.value ?? '';
    row.out.hidden = !field.is_optional || field.value === null;
    return row.place;
  });
  const place = byId('sliders');
  if (place.children.length !== places.length || places.some((row, n) => place.children[n] !== row)) place.replaceChildren(...places);
}

function showFlags(flags) {
  byId('flags').replaceChildren(...flags.map(({ flag, on }) => {
    const box = make('input', { type: 'checkbox', checked: on, 'aria-label': flag });
    box.addEventListener('change', () => ask('change', { flag: { flag, on: box.checked } }));
    return make('label', {}, box, ` ${flag}`);
  }));
}

function shown({ view }) {
  byId('title').textContent = view.title ?? '';
  byId('description').textContent = view.description ?? '';
  const outline = byId('outline');
  outline.textContent = view.refusal ?? view.outline ?? '';
  outline.className = view.refusal ? 'refusal' : 'plan';
  byId('remedies').replaceChildren(...(view.remedies ?? []).map((remedy) =>
    make('button', { onclick: () => ask('change', { set: remedy.set }) }, `Take it: ${remedy.words}`)));
  byId('words').textContent = view.words ?? '';
  if (view.sliders) showSliders(view.sliders);
  if (view.flags) showFlags(view.flags);
  charts.show({
    curves: view.curves ?? [], points: view.points ?? [], limits: view.limits ?? [[], [], [], []],
    headings: view.headings ?? [], along: view.along, selected: null,
  });
}

begin(shown);
