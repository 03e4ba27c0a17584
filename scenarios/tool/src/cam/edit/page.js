'use strict';
// The page of a cam plate.

page.asked = {
  master_velocity: 360, over_time: false, turns: 1,
  velocity: null, acceleration: null, jerk: null, torque: null,
  least: 'acceleration', selected: null,
};
// What the address says, such as #master_velocity=720&acceleration=5000.
for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
  if (!(name in page.asked)) continue;
  page.asked[name] = name === 'over_time' ? value === 'true' : name === 'least' ? value : Number(value);
}

const charts = new Charts(byId('charts'), {
  pick: (point) => {
    page.asked.selected = point;
    ask('view');
  },
  drag: (point, quantity, along, value, grain, gesture) =>
    ask('change', { drag: { point, quantity, along, value, grain } }, gesture),
  insert: (along, value, grain) => ask('change', { insert: { along, value, grain } }),
});

function choose(name, value) {
  page.asked[name] = value;
  ask('view');
}

function showHead(head) {
  if (!head) return;
  const set = (field) => (value) => ask('change', { head: { field, value } });
  const word = (field, label, properties) => {
    const input = make('input', { type: 'text', value: head[field] ?? '', 'aria-label': label, ...properties });
    input.addEventListener('change', () => set(field)(input.value));
    return make('label', {}, `${label} `, input);
  };
  const parts = [
    word('title', 'Title', { size: 34 }),
    make('label', {}, 'Course ', choice(['linear', 'cyclic'], head.course, set('course'), { 'aria-label': 'Course' })),
    make('label', {}, 'Table ', numberField(head['table-id'], set('table-id'), { min: 1, max: 255, step: 1, 'aria-label': 'Table' })),
    word('master-unit', 'Master in', { size: 4 }),
    word('slave-unit', 'Slave in', { size: 4 }),
  ];
  if (head.kind === 'table') {
    const kinds = ['linear', 'spline', 'sliding-spline'];
    parts.push(make('label', {}, 'Interpolation ', choice(kinds, head['table.interpolation'], set('table.interpolation'))));
  }
  refill(byId('head'), ...parts);
}

function showAsked() {
  const { asked } = page;
  const field = (name, label, title) =>
    make('label', { title: title ?? '' }, `${label} `, numberField(asked[name], (value) => choose(name, value), { 'aria-label': label }));
  const over = choice(['over the master', 'over time'], asked.over_time ? 'over time' : 'over the master',
    (word) => choose('over_time', word === 'over time'), { id: 'over' });
  refill(byId('asked'),
    over,
    field('master_velocity', 'Master velocity', 'Master units per second'),
    make('label', {}, 'Turns ', numberField(asked.turns, (value) => choose('turns', value ?? 1), { min: 1, max: 20, step: 1, 'aria-label': 'Turns' })),
    field('velocity', 'Max. velocity'), field('acceleration', 'Max. acceleration'),
    field('jerk', 'Max. jerk'), field('torque', 'Max. torque', 'The highest |velocity times acceleration|'));
}

const MARKS = ['v', 'a', 'j'];

function marks(joint) {
  return (joint ?? []).map((mark, n) =>
    make('span', { className: `mark ${mark.goes_on ? 'good' : 'bad'}`, title: mark.words }, MARKS[n]));
}

function showPoints(view) {
  const points = view.points ?? [];
  const isTable = view.head?.kind === 'table';
  const set = (point, field) => (value) => ask('change', { set: { point, field, value } });
  const columns = isTable ? ['master', 'slave'] : ['master', 'slave', 'velocity', 'acceleration', 'jerk'];
  const headings = isTable ? ['', 'master', 'slave', ''] : ['', ...columns, 'law', 'type', 'goes', ''];
  const rows = points.slice(0, 500).map((point, n) => {
    const cells = columns.map((field) => make('td', {},
      numberField(point[field], set(n, field), { 'aria-label': `point ${n + 1} ${field}` })));
    if (!isTable) {
      const isLast = n + 1 === points.length;
      const law = point.law === null ? '' : choice(view.laws, point.law, set(n, 'law'), { 'aria-label': `point ${n + 1} law` });
      cells.push(make('td', {}, isLast && point.law === null ? '' : law),
        make('td', {}, choice(view.types, point.type, set(n, 'type'), { 'aria-label': `point ${n + 1} type` })),
        make('td', { className: 'left marks' }, ...marks(point.joint)));
    }
    const out = make('button', { title: 'Take it out', onclick: () => ask('change', { remove: { point: n } }) }, '×');
    return make('tr', { className: page.asked.selected === n ? 'selected' : '', onclick: () => {
      if (page.asked.selected !== n) choose('selected', n);
    } }, make('td', {}, String(n + 1)), ...cells, make('td', {}, out));
  });
  const heading = make('tr', {}, ...headings.map((text) => make('th', {}, text)));
  refill(byId('points'), make('thead', {}, heading), make('tbody', {}, ...rows));
}

function showAdvice(advice) {
  const part = byId('advice-part');
  part.hidden = !advice || Boolean(advice.error);
  if (part.hidden) return;
  const least = choice(['velocity', 'acceleration', 'jerk', 'torque'], page.asked.least, (word) => choose('least', word), { id: 'least' });
  byId('advice-of').replaceChildren(`from point ${advice.point}, by the least `, least);
  const headings = ['law', 'velocity', 'acceleration', 'jerk', 'torque', 'against it', ''];
  const rows = advice.rows.map((row, n) => make('tr', { className: n === 0 && row.passes ? 'best' : '' },
    make('td', { className: 'left' }, row.law),
    ...row.shown.map((text) => make('td', {}, text)),
    make('td', { className: 'left quiet remarks' }, row.remarks),
    make('td', {}, make('button', {
      onclick: () => ask('change', { set: { point: advice.point - 1, field: 'law', value: row.law } }),
    }, 'Take'))));
  byId('advice').replaceChildren(
    make('thead', {}, make('tr', {}, ...headings.map((text, n) => make('th', { className: n === 0 || n === 5 ? 'left' : '' }, text)))),
    make('tbody', {}, ...rows));
}

function showCharacteristics(values, compared) {
  const place = byId('characteristics');
  if (!values || values.error) {
    place.replaceChildren();
    return;
  }
  byId('characteristics-at').textContent = values.at;
  const headings = ['', 'least', 'at', 'most', 'at', 'limit', ...(compared ? ['least of the other', 'most of the other'] : [])];
  const cell = (text, isOver) => make('td', { className: isOver ? 'over' : '' }, text ?? '');
  const ranges = values.ranges.map((row) => make('tr', {}, make('td', {}, row.name),
    cell(row.own.least, row.is_over), cell(row.own.least_at), cell(row.own.most, row.is_over), cell(row.own.most_at), cell(row.limit),
    ...(compared ? [cell(row.other?.least), cell(row.other?.most)] : [])));
  const figures = values.figures.map((row) => make('tr', {}, make('td', {}, row.name), cell(''), cell(''), cell(row.own), cell(''), cell(''),
    ...(compared ? [cell(''), cell(row.other)] : [])));
  place.replaceChildren(make('thead', {}, make('tr', {}, ...headings.map((text) => make('th', {}, text)))),
    make('tbody', {}, ...ranges, ...figures));
}

function showTarget(target) {
  byId('target-part').hidden = !target;
  if (target) byId('target').textContent = `${target.name}, as plate ${target.table ?? '–'}`;
}

function shown({ view }) {
  if (page.asked.selected !== null && view.points && page.asked.selected >= view.points.length) page.asked.selected = null;
  showHead(view.head);
  showAsked();
  showPoints(view);
  showAdvice(view.advice);
  showCharacteristics(view.characteristics, view.compared);
  byId('description').textContent = view.description ?? '';
  byId('steps').textContent = view.steps ?? '';
  byId('compared').textContent = view.compared ? `with ${view.compared}, dashed` : '';
  showTarget(view.target);
  charts.show({
    curves: view.curves ?? [], points: view.points ?? [], limits: view.limits ?? [[], [], [], []],
    headings: view.headings ?? [], along: view.along, selected: page.asked.selected,
  });
}

byId('compare-this').addEventListener('click', () => ask('act', { do: 'compare-with-this' }));
byId('compare-none').addEventListener('click', () => ask('act', { do: 'compare-with-none' }));
byId('compare-file').addEventListener('change', async (event) => {
  const [file] = event.target.files;
  if (file) ask('act', { compare: { name: file.name, text: await file.text() } });
});
for (const mode of ['next-cycle', 'instantaneous', 'as-soon-as-possible']) byId('activation').append(make('option', { value: mode }, mode));
for (const button of document.querySelectorAll('[data-do]')) {
  button.addEventListener('click', () => ask('act', { do: button.dataset.do, activation: byId('activation').value }));
}
document.addEventListener('keydown', (event) => {
  if (event.key !== 'Delete' || page.asked.selected === null || event.target.matches('input, textarea, select')) return;
  ask('change', { remove: { point: page.asked.selected } });
});
begin(shown);
