'use strict';
// The page: which nodes there are, which signals are chosen, what is shown of them, and what slaves are told.

const $ = (id) => document.getElementById(id);
const make = (tag, text, props = {}) => Object.assign(document.createElement(tag), { textContent: text }, props);

// Memory for values of a node: two minutes of a hundred signals at 1 kHz.
const MOST_VALUES = 12e6;
const MOST_ROWS = 120e3;
const MOST_LINES = 500;
// How often the nodes are asked who they are.
const ROUND_MS = 500;

const state = {
  nodes: [],
  commands: false,
  // By node: its signals, their newest rows, the words of states, its stream and how that goes.
  sources: new Map(),
  // `node:signal`, in the order they were chosen.
  chosen: [],
  span: 5,
  // `time`, `against` the first signal, or `spectrum`.
  kind: 'time',
  // The time at the right edge; undefined follows what comes.
  right: undefined,
  zero: undefined,
  cursors: { A: undefined, B: undefined },
  ranges: new Map(),
  trigger: { mode: 'off', signal: '', edge: 'rising', level: 0, since: undefined, at: undefined },
  isDirty: true,
};

// --- Who is there

async function round() {
  try {
    const answer = await (await fetch('nodes')).json();
    state.nodes = answer.nodes;
    state.commands = answer.commands;
  } catch (error) {
    $('told').textContent = 'the tool that gives out this page is gone';
    state.nodes = state.nodes.map((node) => ({ ...node, is_alive: false }));
  }
  showNodes();
  for (const node of state.nodes) if (node.is_alive) learn(node.name);
  if (!$('slaves').hidden) showSlaves();
}

function kind(node) {
  if (!node.is_alive) return ['bad', 'gone'];
  const health = node.status?.health ?? 'silent';
  return [health === 'ok' ? 'good' : health.startsWith('waiting') || health === 'starting-up' ? 'wait' : 'bad', health];
}

function showNodes() {
  $('nodes').replaceChildren(...state.nodes.map((node) => {
    const [tone, health] = kind(node);
    const lab = node.status?.lab;
    const said = lab ? `${health}, lab` : health;
    const title = [node.status?.role, lab].filter(Boolean).join(', ');
    return make('li', `${node.name}: ${said}`, { className: `badge ${tone}`, title });
  }));
}

// --- Signals

async function learn(node) {
  if (state.sources.has(node)) return;
  const source = {
    signals: [], rows: undefined, words: new Map(), stream: undefined, epoch: '', restarts: 0, missing: 0, unknown: [],
  };
  state.sources.set(node, source);
  if (!await learnSignals(node, source)) setTimeout(() => state.sources.delete(node), 2000);
}

// Another run of the node may have another config, and so other signals.
async function learnSignals(node, source) {
  const answer = await fetch(`signals/${node}`).catch(() => undefined);
  if (!answer?.ok) return false;
  source.signals = await answer.json();
  showChannels();
  arrange();
  listen(node);
  return true;
}

function showChannels() {
  const filter = $('filter').value.trim().toLowerCase().split(/\s+/);
  const open = new Set([...document.querySelectorAll('#channels details[open]')].map((part) => part.dataset.of));
  const parts = [];
  for (const [node, { signals }] of [...state.sources].sort()) {
    const groups = new Map();
    for (const signal of signals) {
      const key = `${node}:${signal.name}`;
      if (!filter.every((word) => key.toLowerCase().includes(word))) continue;
      const instance = signal.instance || 'node';
      if (!groups.has(instance)) groups.set(instance, []);
      groups.get(instance).push([key, signal]);
    }
    if (!groups.size) continue;
    const part = make('details', '', { open: true });
    part.append(make('summary', node));
    for (const [instance, of] of groups) {
      const inner = make('details', '');
      inner.dataset.of = `${node}/${instance}`;
      inner.open = open.has(inner.dataset.of) || filter[0] !== '' || of.some(([key]) => state.chosen.includes(key));
      inner.append(make('summary', `${instance} (${of[0][1].group})`));
      for (const [key, signal] of of) {
        const own = signal.instance ? signal.name.slice(signal.instance.length + 1) : signal.name;
        const label = make('label', '');
        const box = make('input', '', { type: 'checkbox', checked: state.chosen.includes(key) });
        box.addEventListener('change', () => choose(key, box.checked));
        label.append(box, ` ${own}`, signal.unit ? make('span', ` ${signal.unit}`, { className: 'quiet' }) : '');
        inner.append(label);
      }
      part.append(inner);
    }
    parts.push(part);
  }
  $('channels').replaceChildren(...parts);
}

function choose(key, isChosen) {
  state.chosen = state.chosen.filter((other) => other !== key);
  if (isChosen) state.chosen.push(key);
  remember();
  listen(key.split(':')[0]);
  arrange();
}

const split = (key) => [key.slice(0, key.indexOf(':')), key.slice(key.indexOf(':') + 1)];

// A name that ends in ' is the rate of change of that signal, from cycle to cycle: of a position the velocity that arrives.
const isRate = (name) => name.endsWith("'");
const base = (name) => (isRate(name) ? name.slice(0, -1) : name);

function signalOf(key) {
  const [node, name] = split(key);
  const signal = state.sources.get(node)?.signals.find((known) => known.name === base(name));
  return signal && isRate(name) ? { ...signal, name, unit: `${signal.unit || '1'}/s` } : signal;
}

// --- Rows as they come

async function listen(node) {
  const source = state.sources.get(node);
  if (!source) return;
  source.stream?.abort();
  const names = state.chosen.map(split).filter(([of]) => of === node).map(([, name]) => name);
  const shown = names.filter((name) => signalOf(`${node}:${name}`));
  const known = [...new Set(shown.map(base))];
  if (!known.length) {
    source.rows = undefined;
    return;
  }
  const most = Math.floor(Math.min(MOST_ROWS, MOST_VALUES / shown.length));
  const rows = new Rows([...known, ...shown.filter(isRate)], most);
  if (source.rows) rows.adopt(source.rows);
  source.rows = rows;
  const words = new Map(known.map((name) => [name, []]));
  const abort = new AbortController();
  source.stream = abort;
  try {
    const query = new URLSearchParams({ signals: known.join(',') });
    const answer = await fetch(`rows/${node}?${query}`, { signal: abort.signal });
    if (!answer.ok) throw new Error(await answer.text());
    // Words are numbered anew by each stream: what is there of them goes.
    for (const name of known) {
      if (signalOf(`${node}:${name}`).is_word) rows.forget(name);
    }
    source.words = words;
    await take(answer.body.getReader(), (head, numbers) => block(node, source, rows, words, head, numbers));
  } catch (error) {
    if (abort.signal.aborted) return;
  }
  setTimeout(() => source.stream === abort && listen(node), 1000);
}

// Cuts what comes into blocks: a head in JSON and numbers.
async function take(reader, each) {
  let rest = new Uint8Array(0);
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const all = new Uint8Array(rest.length + value.length);
    all.set(rest);
    all.set(value, rest.length);
    rest = all;
    for (;;) {
      const block = cut(rest);
      if (!block) break;
      each(block.head, block.numbers);
      rest = rest.slice(block.length);
    }
  }
}

const text = new TextDecoder();

function cut(bytes) {
  if (bytes.length < 4) return undefined;
  const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  if (bytes.length < 4 + length) return undefined;
  const head = JSON.parse(text.decode(bytes.subarray(4, 4 + length)));
  const start = Math.ceil((4 + length) / 8) * 8;
  const end = start + 8 * head.rows * (1 + head.signals);
  if (bytes.length < end) return undefined;
  return { head, numbers: new Float64Array(bytes.slice(start, end).buffer), length: end };
}

function block(node, source, rows, words, head, numbers) {
  for (const [n, [from, more]] of Object.entries(head.words)) {
    words.get(rows.names[n]).splice(from, Infinity, ...more);
  }
  for (const line of head.log) log(node, line);
  if (source.epoch && head.epoch !== source.epoch) {
    source.restarts++;
    learnSignals(node, source);
  } else if (source.piece !== undefined && source.stream === source.counted) source.missing += head.piece - source.piece - 1;
  Object.assign(source, { epoch: head.epoch, piece: head.piece, counted: source.stream, unknown: head.unknown });
  const column = (n) => numbers.subarray(n * head.rows, (n + 1) * head.rows);
  const times = column(0);
  const rate = (name) => rates(rows, times, base(name), column(rows.names.indexOf(base(name)) + 1));
  rows.push(times, rows.names.map((name, n) => (isRate(name) ? rate(name) : column(n + 1))));
  state.zero ??= rows.times[0];
  document.body.dataset.rows = (Number(document.body.dataset.rows) || 0) + head.rows;
  watchTrigger();
  state.isDirty = true;
}

// The change of each row against the one before it, per second.
function rates(rows, times, name, values) {
  let [time, value] = rows.length ? [rows.last(), rows.columns.get(name)[rows.length - 1]] : [NaN, NaN];
  return values.map((now, n) => {
    const rate = (now - value) / (times[n] - time);
    [time, value] = [times[n], now];
    return rate;
  });
}

function log(node, { at, level, text: said }) {
  const time = new Date(at * 1000).toISOString().slice(11, 23);
  const tone = { error: 'bad', warning: 'wait' }[level] ?? '';
  $('log').prepend(make('li', `${time} ${node}: ${said}`, { className: tone }));
  while ($('log').children.length > MOST_LINES) $('log').lastChild.remove();
}

// --- Panes: signals of one unit share one, states have a lane each

let panes = [];

function arrange() {
  const units = new Map();
  for (const key of state.chosen) {
    const signal = signalOf(key);
    if (!signal) continue;
    const unit = signal.is_word ? 'states' : signal.unit || 'number';
    if (!units.has(unit)) units.set(unit, []);
    units.get(unit).push(key);
  }
  const height = Math.max(90, Math.min(260, 560 / Math.max(1, units.size)));
  panes = [...units].map(([unit, keys]) => {
    const canvas = make('canvas', '');
    canvas.style.height = `${unit === 'states' ? 24 * keys.length + 24 : height}px`;
    canvas.setAttribute('aria-label', `${unit}: ${keys.join(', ')}`);
    const pane = { unit, keys, canvas, shown: [0, 1] };
    handle(pane);
    return pane;
  });
  $('panes').replaceChildren(...panes.map(({ canvas }) => {
    const part = make('div', '', { className: 'pane' });
    part.append(canvas);
    return part;
  }));
  $('figures').hidden = !panes.length;
  $('hint').hidden = panes.length > 0;
  const numbers = state.chosen.filter((key) => signalOf(key) && !signalOf(key).is_word);
  $('trigger-signal').replaceChildren(...numbers.map((key) => make('option', key, { value: key })));
  if (numbers.includes(state.trigger.signal)) $('trigger-signal').value = state.trigger.signal;
  else state.trigger.signal = numbers[0] ?? '';
  state.isDirty = true;
}

// Colours that differ as long as there are not very many: the hue turns by the golden angle.
function colour(key) {
  const n = state.chosen.indexOf(key);
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  return `hsl(${(210 + n * 137.508) % 360} ${70 - (n % 3) * 12}% ${dark ? 64 : 38 + (n % 2) * 8}%)`;
}

function newest() {
  const lasts = [...state.sources.values()].map((source) => source.rows?.last()).filter((time) => time !== undefined);
  return lasts.length ? Math.max(...lasts) : undefined;
}

function view() {
  const right = state.right ?? newest() ?? state.span;
  return { from: right - state.span, to: right, zero: state.zero ?? right - state.span };
}

function paint() {
  requestAnimationFrame(paint);
  if (!state.isDirty || $('scope').hidden) return;
  state.isDirty = false;
  const shown = view();
  for (const pane of panes) {
    const curves = pane.keys.map((key) => curve(key)).filter(Boolean);
    if (!curves.length) continue;
    pane.shown = paintPane(pane, curves, shown);
  }
  document.body.dataset.frames = (Number(document.body.dataset.frames) || 0) + 1;
}

// States are shown over time in any case.
function paintPane({ canvas, unit }, curves, shown) {
  const kind = curves.every(({ words }) => words) ? 'time' : state.kind;
  const range = state.ranges.get(rangeKey(unit));
  if (kind === 'spectrum') return drawSpectrum(canvas, curves, shown, range, unit);
  const first = state.chosen.find((key) => curve(key) && !signalOf(key).is_word);
  if (kind === 'against') return drawAgainst(canvas, curves, { ...curve(first), unit: signalOf(first).unit }, shown, range, unit);
  return draw(canvas, curves, shown, state.cursors, range, unit);
}

// Amplitudes have another range than values.
const rangeKey = (unit) => (state.kind === 'spectrum' ? `spectrum ${unit}` : unit);

function curve(key) {
  const [node, name] = split(key);
  const source = state.sources.get(node);
  if (!source?.rows?.columns.has(name)) return undefined;
  const words = signalOf(key).is_word ? source.words.get(name) ?? [] : undefined;
  return { rows: source.rows, name, colour: colour(key), words };
}

function shownAsCsv() {
  const curves = state.chosen.filter((key) => curve(key)).map((key) => ({ key, ...curve(key) }));
  return csvOf(curves, view());
}

// --- Figures of the window, and between cursors

const number = (value) => {
  if (value === undefined || Number.isNaN(value)) return '–';
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return String(value);
  return Math.abs(value) >= 1e-4 && Math.abs(value) < 1e9 ? String(+value.toPrecision(9)) : value.toExponential(4);
};

function showFigures() {
  if ($('scope').hidden) return;
  const { from, to } = view();
  const { A, B } = state.cursors;
  $('figures').tBodies[0].replaceChildren(...state.chosen.filter((key) => curve(key)).map((key) => {
    const { rows, name, words } = curve(key);
    const signal = signalOf(key);
    const say = words ? (value) => words[value] ?? '–' : number;
    const at = (time) => (time === undefined ? NaN : rows.at(name, time));
    const of = (words ? undefined : rows.figures(name, from, to)) ?? {};
    const cells = [key, signal.unit, say(at(rows.last())), ...['least', 'most', 'mean', 'rms'].map((f) => number(of[f])),
      say(at(A)), say(at(B)), words ? '' : number(at(B) - at(A))];
    const row = make('tr', '');
    row.style.setProperty('--colour', colour(key));
    row.append(...cells.map((cell) => make('td', cell)));
    if (!words && !isRate(name)) row.append(rateButton(key));
    return row;
  }));
  const apart = A !== undefined && B !== undefined;
  $('cursors').textContent = apart
    ? `B − A: ${number((B - A) * 1e3)} ms${A === B ? '' : `, ${number(1 / Math.abs(B - A))} Hz`}`
    : '';
  showGaps();
}

function rateButton(key) {
  const cell = make('td', '');
  const isShown = state.chosen.includes(`${key}'`);
  const button = make('button', 'd/dt', { title: 'its change from cycle to cycle, per second' });
  button.setAttribute('aria-pressed', String(isShown));
  button.addEventListener('pointerdown', () => choose(`${key}'`, !isShown));
  cell.append(button);
  return cell;
}

function showGaps() {
  const told = [...state.sources].flatMap(([node, { restarts, missing, unknown }]) => [
    ...(restarts ? [`${node}: started anew ${restarts} times`] : []),
    ...(missing ? [`${node}: ${missing} pieces of 50 ms are missing`] : []),
    ...(unknown.length ? [`${node}: no signals of this run: ${unknown.join(', ')}`] : []),
  ]);
  $('told').textContent = told.join(', ');
  document.body.dataset.missing = [...state.sources.values()].reduce((sum, { missing }) => sum + missing, 0);
}

// --- Mouse and keys

function handle(pane) {
  const { canvas } = pane;
  const timeAt = (event) => {
    const place = area(canvas);
    const { from, to } = view();
    return from + ((event.offsetX - place.left) / place.width) * (to - from);
  };
  let drag;
  canvas.addEventListener('pointerdown', (event) => {
    drag = { x: event.offsetX, right: view().to, moved: false, cursor: event.shiftKey ? 'B' : 'A' };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!drag || (!drag.moved && Math.abs(event.offsetX - drag.x) < 4)) return;
    drag.moved = true;
    state.right = drag.right - ((event.offsetX - drag.x) / area(canvas).width) * state.span;
    showPause();
  });
  canvas.addEventListener('pointerup', (event) => {
    if (drag && !drag.moved && state.kind === 'time') state.cursors[drag.cursor] = timeAt(event);
    drag = undefined;
    state.isDirty = true;
    showFigures();
  });
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const factor = 1.2 ** Math.sign(event.deltaY);
    if (event.offsetX < LEFT) zoomValues(pane, event, factor);
    else zoomTime(timeAt(event), factor);
  }, { passive: false });
  canvas.addEventListener('dblclick', () => {
    state.ranges.delete(rangeKey(pane.unit));
    state.isDirty = true;
  });
}

function zoomTime(around, factor) {
  const { to } = view();
  const span = Math.min(120, Math.max(0.005, state.span * factor));
  if (state.right !== undefined) state.right = around + (to - around) * (span / state.span);
  state.span = span;
  $('span').value = +span.toPrecision(4);
  remember();
  state.isDirty = true;
}

function zoomValues(pane, event, factor) {
  const place = area(pane.canvas);
  const [low, high] = pane.shown;
  const around = high - ((event.offsetY - place.top) / place.height) * (high - low);
  state.ranges.set(rangeKey(pane.unit), zoomed(pane.shown, around, factor));
  state.isDirty = true;
}

function pause(isPaused) {
  state.right = isPaused ? newest() : undefined;
  if (!isPaused) arm();
  showPause();
}

function showPause() {
  $('pause').textContent = state.right === undefined ? 'Pause' : 'Go on';
  state.isDirty = true;
}

// --- Trigger

function arm() {
  Object.assign(state.trigger, { since: newest(), at: undefined });
  showTrigger();
}

// A shot is whole when three quarters of the window have come after it.
function watchTrigger() {
  const { trigger } = state;
  if (trigger.mode === 'off' || !trigger.signal) return;
  const isShown = state.right !== undefined && trigger.mode === 'single';
  if (isShown) return;
  const [node, name] = split(trigger.signal);
  const rows = state.sources.get(node)?.rows;
  if (!rows?.columns.has(name)) return;
  trigger.since ??= rows.last();
  if (trigger.at === undefined) {
    trigger.at = rows.crossing(name, trigger.since, trigger.level, trigger.edge === 'rising');
    trigger.since = rows.last();
  }
  if (trigger.at !== undefined && rows.last() >= trigger.at + 0.75 * state.span) {
    state.right = trigger.at + 0.75 * state.span;
    trigger.since = Math.max(trigger.since, state.right);
    if (trigger.mode === 'normal') trigger.at = undefined;
    document.body.dataset.shots = (Number(document.body.dataset.shots) || 0) + 1;
    showPause();
  }
  showTrigger();
}

function showTrigger() {
  const { mode, at } = state.trigger;
  const isDone = mode === 'single' && state.right !== undefined && at !== undefined;
  $('trigger-state').textContent = mode === 'off' ? '' : isDone ? 'taken' : at === undefined ? 'armed' : 'triggered';
}

// --- Slaves and clocks

const ASKED = new Map();
const BUTTONS = [
  ['Power on', { power: true }],
  ['Power off', { power: false }],
  ['Reset', { reset: {} }],
  ['Halt', { halt: { dynamics: {} } }],
  ['Stop', { stop: { dynamics: {} } }],
  ['Gear in 1:1', { 'gear-in': { ratio: 1.0 } }],
  ['Gear out', { 'gear-out': {} }],
  ['Cam out', { 'cam-out': {} }],
];
const FAR_BUTTONS = [
  ['Correction on', { 'filter-mode': 'observer' }],
  ['Correction off', { 'filter-mode': 'bypass' }],
  ['Initialise again', { 're-initialise': {} }],
];

// The right to command, as a part of the address that was printed or logged when the page started.
const TOKEN = new URLSearchParams(location.search).get('token') ?? '';

async function order(node, addressee, command, isTrial) {
  const body = JSON.stringify({ version: 1, ...addressee, command, 'dry-run': isTrial });
  const headers = { 'x-coaxle-page': TOKEN };
  const answer = await fetch(`orders/${node}`, { method: 'POST', headers, body });
  if (!answer.ok) return { outcome: 'not-taken', text: await answer.text() };
  return answer.json();
}

// Which commands a slave would take now: it is asked when its state changes, and every few seconds.
async function ask(node, addressee, buttons, stamp, id) {
  const known = ASKED.get(id);
  if (known && (known.isBusy || (known.stamp === stamp && Date.now() - known.at < 5000))) return;
  const asked = { ...known, stamp, at: Date.now(), isBusy: true };
  ASKED.set(id, asked);
  const allowed = new Set();
  for (const [label, command] of buttons) {
    const answer = await order(node, addressee, command, true).catch(() => undefined);
    if (answer?.outcome === 'accepted') allowed.add(label);
  }
  Object.assign(asked, { allowed, isBusy: false });
}

function showSlaves() {
  const parts = [];
  for (const { name, is_alive: isAlive, status } of state.nodes) {
    if (!status) continue;
    const slaves = Object.entries(status.slaves ?? {});
    const far = Object.entries(status.far ?? {});
    if (!slaves.length && !far.length) continue;
    parts.push(make('h2', `${name} (${status.role})${isAlive ? '' : ', gone'}`));
    if (far.length) {
      const heads = ['clock of', 'health', 'mode', 'synced', 'drift', '± (1σ)', 'delay', '±', 'data age', 'beats', ''];
      parts.push(table(heads, far.map(([of, s]) => [
        of, s.health ?? '–', s.mode ?? '–', s.synced ? 'yes' : 'no', [s.drift_ppm, 'ppm'], [s.drift_sigma_ppm, 'ppm', 2],
        [s.delay_us, 'µs', 4], [s.delay_uncertainty_us, 'µs', 3], [s.age_cycles, 'cycles'], [s.beats, ''],
        buttons(name, { far: of }, FAR_BUTTONS, `${s.health} ${s.mode}`, isAlive),
      ])));
    }
    if (slaves.length) {
      parts.push(table(['slave', 'state', 'coupling', 'position', 'velocity', 'distance', 'program', 'waits for', ''],
        slaves.map(([of, s]) => [
          of, s.state, s.phase ?? '–', [s.position, s.unit ?? ''], [s.velocity, `${s.unit ?? ''}/s`],
          [s.distance, s.unit ?? '', 4], s.program ? `${s.program} ${s.program_step ?? ''}` : '–', s.program_waits_for ?? '–',
          buttons(name, { slave: of }, BUTTONS, `${s.state} ${s.phase}`, isAlive),
        ])));
    }
  }
  if (!parts.length) parts.push(make('p', 'No node with slaves or far clocks is there.'));
  const why = !state.commands ? 'Commands are off: start it with --commands to have buttons.'
    : !TOKEN ? 'Commands need the address with ?token=, which was printed or logged when the page started.' : undefined;
  if (why) parts.push(make('p', why, { className: 'quiet' }));
  $('slaves').replaceChildren(...parts);
}

function table(heads, rows) {
  const all = make('table', '');
  const head = make('tr', '');
  head.append(...heads.map((text) => make('th', text)));
  all.append(head, ...rows.map((cells) => {
    const row = make('tr', '');
    row.append(...cells.map((cell) => {
      if (cell instanceof Node) return cell;
      if (Array.isArray(cell)) return make('td', quantity(...cell), { className: 'number' });
      return make('td', cell);
    }));
    return row;
  }));
  return all;
}

function quantity(value, unit, digits = 7) {
  return `${number(Number.isInteger(value) ? value : +(value ?? NaN).toPrecision(digits))} ${unit}`;
}

function buttons(node, addressee, all, stamp, isAlive) {
  const cell = make('td', '', { className: 'commands' });
  if (!state.commands || !TOKEN || !isAlive) return cell;
  const id = `${node}/${JSON.stringify(addressee)}`;
  ask(node, addressee, all, stamp, id);
  const asked = ASKED.get(id);
  for (const [label, command] of all) {
    if (!asked?.allowed?.has(label)) continue;
    const button = make('button', label);
    button.addEventListener('click', async () => {
      const answer = await order(node, addressee, command, false);
      asked.said = answer.outcome === 'accepted' ? `${label}: accepted` : `${label}: ${answer.outcome}, ${answer.text}`;
      asked.at = 0;
      showSlaves();
    });
    cell.append(button, ' ');
  }
  if (asked?.said) cell.append(make('span', asked.said, { className: 'said quiet' }));
  return cell;
}

// --- The address remembers what is shown, so that it can be kept and sent

function remember() {
  const hash = new URLSearchParams({ signals: state.chosen.join(','), span: $('span').value });
  if (state.kind !== 'time') hash.set('kind', state.kind);
  const tab = TABS.find((name) => !$(name).hidden);
  if (tab !== 'scope') hash.set('tab', tab);
  history.replaceState(null, '', `#${hash}`);
}

function recall() {
  const hash = new URLSearchParams(location.hash.slice(1));
  state.chosen = (hash.get('signals') ?? '').split(',').filter(Boolean);
  const span = Number(hash.get('span'));
  if (span > 0) state.span = $('span').value = Math.min(120, span);
  $('kind').value = hash.get('kind') ?? 'time';
  state.kind = $('kind').value ||= 'time';
  show(hash.get('tab'));
}

const TABS = ['scope', 'slaves', 'plant'];

function show(wanted) {
  const tab = TABS.includes(wanted) ? wanted : 'scope';
  for (const name of TABS) {
    $(name).hidden = name !== tab;
    $(`tab-${name}`).setAttribute('aria-pressed', String(name === tab));
  }
  if (tab === 'slaves') showSlaves();
  if (tab === 'plant') showPlant();
  state.isDirty = true;
}

// Drawn by the node or scope from what all nodes say and measure: not more often than anybody looks.
const PLANT_MS = 5000;

function showPlant() {
  if (!$('plant').hidden) $('plant').firstElementChild.src = `plant.svg?${Date.now()}`;
}

// --- At the start

function listenToTools() {
  for (const name of TABS) $(`tab-${name}`).addEventListener('click', () => { show(name); remember(); });
  $('filter').addEventListener('input', showChannels);
  $('kind').addEventListener('change', () => {
    state.kind = $('kind').value;
    remember();
    state.isDirty = true;
  });
  $('save-rows').addEventListener('click', () => saveText('scope.csv', shownAsCsv()));
  $('save-picture').addEventListener('click', () => panes.length && save('scope.png', pictureOf(panes, colour)));
  $('pause').addEventListener('click', () => pause(state.right === undefined));
  $('span').addEventListener('change', () => {
    const span = Number($('span').value);
    if (span > 0) state.span = Math.min(120, span);
    remember();
    state.isDirty = true;
  });
  const settings = { mode: 'trigger-mode', signal: 'trigger-signal', edge: 'trigger-edge', level: 'trigger-level' };
  for (const [name, id] of Object.entries(settings)) {
    $(id).addEventListener('change', () => {
      state.trigger[name] = name === 'level' ? Number($(id).value) : $(id).value;
      state.right = undefined;
      arm();
      showPause();
    });
  }
  document.addEventListener('keydown', (event) => {
    if (event.key !== ' ' || event.target.matches('input, select, button, summary')) return;
    event.preventDefault();
    pause(state.right === undefined);
  });
  addEventListener('resize', () => { state.isDirty = true; });
}

listenToTools();
recall();
setInterval(round, ROUND_MS);
setInterval(showFigures, 250);
setInterval(showPlant, PLANT_MS);
round();
paint();
