'use strict';
// The least and the most of a column of values, kept by blocks of blocks: what a window or a pixel shows of them costs a few
// steps, however many rows it has. What is not known (NaN) is in none of them.

// So many blocks are one of the next level.
const FAN = 8;
const MOST_LEVELS = 4;
// Sums are kept of blocks of the second level alone: they take as much memory as four of the others.
const SUMMED = 1;
const SUMMED_ROWS = FAN ** (SUMMED + 1);

class Pyramid {
  constructor(column) {
    this.column = column;
    // Of each level the least and the most of every block.
    this.levels = [];
    for (let size = FAN; this.levels.length < MOST_LEVELS && 16 * size <= column.length; size *= FAN) {
      const blocks = Math.ceil(column.length / size);
      this.levels.push({ size, least: new Float64Array(blocks), most: new Float64Array(blocks) });
    }
    const summed = this.levels.length > SUMMED ? Math.ceil(column.length / SUMMED_ROWS) : 0;
    [this.sums, this.squares, this.counts] = [0, 1, 2].map(() => new Float64Array(summed));
    // The answer to the last question.
    this.least = Infinity;
    this.most = -Infinity;
  }

  // The rows from here to the end are new, or others than before.
  update(from, length) {
    if (from >= length) return;
    this.levels.forEach(({ size, least, most }, n) => {
      const below = Math.ceil(length / (size / FAN));
      for (let block = Math.floor(from / size); block * size < length; block++) {
        this.begin();
        this.take(n - 1, block * FAN, Math.min(below, (block + 1) * FAN));
        least[block] = this.least;
        most[block] = this.most;
      }
    });
    for (let block = Math.floor(from / SUMMED_ROWS); block < this.sums.length && block * SUMMED_ROWS < length; block++) {
      const [sum, squares, count] = this.added(block * SUMMED_ROWS, Math.min(length, (block + 1) * SUMMED_ROWS));
      this.sums[block] = sum;
      this.squares[block] = squares;
      this.counts[block] = count;
    }
  }

  // The first rows go: a multiple of the largest block, so that the others stay as they are.
  drop(rows) {
    for (const { size, least, most } of this.levels) {
      least.copyWithin(0, rows / size);
      most.copyWithin(0, rows / size);
    }
    for (const each of [this.sums, this.squares, this.counts]) each.copyWithin(0, rows / SUMMED_ROWS);
  }

  // The largest block, rows.
  largest() {
    return this.levels.at(-1)?.size ?? 1;
  }

  // Looks from one row to before another: `least` and `most` are the answer, and cross where nothing is known.
  range(from, to) {
    this.begin();
    let low = from;
    let high = to;
    for (let level = -1; ; level++) {
      const up = Math.ceil(low / FAN);
      const down = Math.floor(high / FAN);
      if (level + 1 >= this.levels.length || up >= down) {
        this.take(level, low, high);
        return;
      }
      this.take(level, low, up * FAN);
      this.take(level, down * FAN, high);
      low = up;
      high = down;
    }
  }

  // Sum, sum of squares and count from one row to before another.
  summed(from, to) {
    const [first, end] = [Math.ceil(from / SUMMED_ROWS), Math.min(Math.floor(to / SUMMED_ROWS), this.sums.length)];
    if (first >= end) return this.added(from, to);
    const all = this.added(from, first * SUMMED_ROWS);
    this.added(end * SUMMED_ROWS, to).forEach((part, n) => { all[n] += part; });
    for (let block = first; block < end; block++) {
      all[0] += this.sums[block];
      all[1] += this.squares[block];
      all[2] += this.counts[block];
    }
    return all;
  }

  // The first row after this one, before `end`, that has another value.
  change(row, end) {
    const value = this.column[row];
    const isUnknown = Number.isNaN(value);
    const { least, most } = this.levels[SUMMED] ?? {};
    let next = row + 1;
    while (next < end) {
      const block = next / SUMMED_ROWS;
      const isWhole = Number.isInteger(block) && block < this.counts.length && next + SUMMED_ROWS <= end;
      const isSame = isWhole && (isUnknown
        ? this.counts[block] === 0
        : this.counts[block] === SUMMED_ROWS && least[block] === value && most[block] === value);
      if (isSame) next += SUMMED_ROWS;
      else if (Object.is(this.column[next], value)) next++;
      else break;
    }
    return next;
  }

  begin() {
    this.least = Infinity;
    this.most = -Infinity;
  }

  // The blocks of a level, or rows below the lowest, from one to before another.
  take(level, from, to) {
    const leasts = level < 0 ? this.column : this.levels[level].least;
    const mosts = level < 0 ? this.column : this.levels[level].most;
    let least = this.least;
    let most = this.most;
    for (let n = from; n < to; n++) {
      if (leasts[n] < least) least = leasts[n];
      if (mosts[n] > most) most = mosts[n];
    }
    this.least = least;
    this.most = most;
  }

  // Row by row.
  added(from, to) {
    let [sum, squares, count] = [0, 0, 0];
    for (let row = from; row < to; row++) {
      const value = this.column[row];
      if (Number.isNaN(value)) continue;
      sum += value;
      squares += value * value;
      count++;
    }
    return [sum, squares, count];
  }
}
