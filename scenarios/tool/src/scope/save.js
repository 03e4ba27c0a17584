'use strict';
// What the scope shows, as files that the browser saves: rows for a table, and the picture.

// Rows from one time to another as CSV. `curves` are { key, rows, name, words }. A column for each signal, a line for each time at which one of their
// nodes has a row; the cell of another node is empty there.
function csvOf(curves, { from, to, zero }) {
  const quoted = (cell) => (/[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
  const lines = [['time_s', 'utc', ...curves.map(({ key }) => key)].map(quoted).join(',')];
  // Signals of a node share their rows.
  const all = [...new Set(curves.map(({ rows }) => rows))];
  const next = new Map(all.map((rows) => [rows, rows.find(from)]));
  const timeOf = (rows) => (next.get(rows) < rows.length ? rows.times[next.get(rows)] : Infinity);
  for (;;) {
    const time = Math.min(...all.map(timeOf));
    if (!(time <= to)) break;
    const cells = curves.map(({ rows, name, words }) => {
      const value = timeOf(rows) === time ? rows.columns.get(name)[next.get(rows)] : NaN;
      if (Number.isNaN(value)) return '';
      return quoted(words ? words[value] ?? '' : String(value));
    });
    lines.push([(time - zero).toFixed(9), utcOf(time), ...cells].join(','));
    for (const rows of all) if (timeOf(rows) === time) next.set(rows, next.get(rows) + 1);
  }
  return `${lines.join('\n')}\n`;
}

// Unix time in s as a date to the microsecond: a double has no more digits.
function utcOf(time) {
  const whole = Math.floor(time);
  const micros = Math.min(999999, Math.floor((time - whole) * 1e6));
  return `${new Date(whole * 1000).toISOString().slice(0, 19)}.${String(micros).padStart(6, '0')}Z`;
}

// All panes below one another, each under the names of its signals.
function pictureOf(panes, colour) {
  const ratio = window.devicePixelRatio || 1;
  const [head, gap] = [20, 8];
  const boxes = panes.map(({ canvas }) => canvas.getBoundingClientRect());
  const picture = document.createElement('canvas');
  picture.width = Math.max(...boxes.map(({ width }) => width + 2 * gap)) * ratio;
  picture.height = boxes.reduce((sum, { height }) => sum + height + head + gap, gap) * ratio;
  const pen = picture.getContext('2d');
  const style = getComputedStyle(document.body);
  pen.fillStyle = style.backgroundColor;
  pen.fillRect(0, 0, picture.width, picture.height);
  pen.scale(ratio, ratio);
  pen.font = '12px system-ui, sans-serif';
  pen.textBaseline = 'middle';
  let top = gap;
  panes.forEach(({ canvas, keys }, n) => {
    let left = gap;
    for (const key of keys) {
      pen.fillStyle = colour(key);
      pen.fillRect(left, top + head / 2 - 5, 10, 10);
      pen.fillStyle = style.color;
      pen.fillText(key, left + 14, top + head / 2);
      left += 14 + pen.measureText(key).width + 16;
    }
    pen.drawImage(canvas, gap, top + head, boxes[n].width, boxes[n].height);
    top += head + boxes[n].height + gap;
  });
  return picture.toDataURL('image/png');
}

function save(name, address) {
  const link = document.createElement('a');
  link.download = name;
  link.href = address;
  link.click();
}

function saveText(name, content) {
  const address = URL.createObjectURL(new Blob([content], { type: 'text/csv' }));
  save(name, address);
  URL.revokeObjectURL(address);
}
