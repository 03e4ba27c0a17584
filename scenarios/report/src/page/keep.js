'use strict';
// A figure as a picture that the browser saves.

// What is drawn of it: canvases, titles, and the legend without what is hidden.
const KEPT = 'canvas, .panel-title, .across, .legend button[aria-pressed="true"], .legend button[aria-pressed="true"] i, .bar span, .bar i';

// Everything at the place where it is seen; `shades` are the colours of a bar.
function keepPicture(place, shades = []) {
  const ratio = window.devicePixelRatio || 1;
  const frame = place.getBoundingClientRect();
  const kept = document.createElement('canvas');
  kept.width = (frame.width + 16) * ratio;
  kept.height = (frame.height + 16) * ratio;
  const pen = kept.getContext('2d');
  const style = getComputedStyle(document.body);
  pen.fillStyle = style.backgroundColor;
  pen.fillRect(0, 0, kept.width, kept.height);
  pen.scale(ratio, ratio);
  for (const part of place.querySelectorAll(KEPT)) {
    const box = part.getBoundingClientRect();
    const [left, top] = [box.left - frame.left + 8, box.top - frame.top + 8];
    if (part.tagName === 'CANVAS') pen.drawImage(part, left, top, box.width, box.height);
    else if (part.tagName === 'I') keepSwatch(pen, part, [left, top, box.width, box.height], shades);
    else keepText(pen, part, style, left, top, box);
  }
  const link = document.createElement('a');
  link.download = `${place.id}.png`;
  link.href = kept.toDataURL('image/png');
  link.click();
}

function keepSwatch(pen, part, [left, top, width, height], shades) {
  const colours = shades.length ? shades : [getComputedStyle(part).borderTopColor];
  const gradient = pen.createLinearGradient(left, 0, left + width, 0);
  colours.forEach((colour, n) => gradient.addColorStop(n / Math.max(1, colours.length - 1), colour));
  pen.fillStyle = gradient;
  pen.fillRect(left, top, width, height);
}

function keepText(pen, part, style, left, top, box) {
  const own = getComputedStyle(part);
  pen.font = `${own.fontWeight} ${own.fontSize} system-ui, sans-serif`;
  pen.fillStyle = style.color;
  pen.textBaseline = 'middle';
  const isAcross = part.className === 'across';
  pen.textAlign = isAcross ? 'center' : 'left';
  // Behind its swatch.
  const swatch = part.querySelector('i');
  const indent = swatch ? swatch.getBoundingClientRect().right - box.left + 5 : 0;
  pen.fillText(part.textContent, isAcross ? left + box.width / 2 : left + indent, top + box.height / 2);
}
