// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
'use strict';

// Zooms and pans the whole pictures by their viewBox. Without this script they are merely still.
const MAX_ZOOM = 32;
const STEP = 1.5;

function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

function makeZoomable(picture) {
  const svg = picture.querySelector('svg.whole');
  const home = svg.viewBox.baseVal;
  const whole = {x: home.x, y: home.y, width: home.width, height: home.height};
  let view = {...whole};

  function show(next) {
    const width = clamp(next.width, whole.width / MAX_ZOOM, whole.width);
    const height = width * whole.height / whole.width;
    view = {
      x: clamp(next.x, whole.x, whole.x + whole.width - width),
      y: clamp(next.y, whole.y, whole.y + whole.height - height),
      width, height,
    };
    svg.setAttribute('viewBox', `${view.x} ${view.y} ${view.width} ${view.height}`);
    svg.classList.toggle('zoomed', width < whole.width);
  }

  // Zooms about a point given in fractions of the picture, which keeps its place.
  function zoom(factor, atX = 0.5, atY = 0.5) {
    const width = clamp(view.width / factor, whole.width / MAX_ZOOM, whole.width);
    const height = width * whole.height / whole.width;
    show({
      x: view.x + atX * (view.width - width),
      y: view.y + atY * (view.height - height),
      width, height,
    });
  }

  function pan(right, down) {
    show({...view, x: view.x + right * view.width, y: view.y + down * view.height});
  }

  function fraction(event) {
    const box = svg.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  const keys = {
    '+': () => zoom(STEP), '=': () => zoom(STEP), '-': () => zoom(1 / STEP), '0': () => show(whole),
    ArrowLeft: () => pan(-0.1, 0), ArrowRight: () => pan(0.1, 0),
    ArrowUp: () => pan(0, -0.1), ArrowDown: () => pan(0, 0.1),
  };
  svg.tabIndex = 0;
  svg.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });

  // The bare wheel scrolls the page; with Ctrl (and so a pinch of a touch pad) it zooms.
  svg.addEventListener('wheel', (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(Math.exp(-clamp(event.deltaY, -60, 60) / 150), ...fraction(event));
  }, {passive: false});

  svg.addEventListener('dblclick', (event) => zoom(2 * STEP, ...fraction(event)));

  svg.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || view.width === whole.width) return;
    svg.setPointerCapture(event.pointerId);
    let last = fraction(event);
    const move = (moved) => {
      const now = fraction(moved);
      pan(last[0] - now[0], last[1] - now[1]);
      last = now;
    };
    svg.addEventListener('pointermove', move);
    const stop = () => svg.removeEventListener('pointermove', move);
    svg.addEventListener('pointerup', stop, {once: true});
    svg.addEventListener('pointercancel', stop, {once: true});
  });

  const controls = document.createElement('div');
  controls.className = 'zoom';
  controls.setAttribute('role', 'group');
  controls.setAttribute('aria-label', 'Zoom');
  for (const [text, label, act] of [
    ['+', 'Zoom in (key +, double click, Ctrl and wheel)', () => zoom(STEP)],
    ['−', 'Zoom out (key -)', () => zoom(1 / STEP)],
    ['Reset', 'Show the whole picture (key 0)', () => show(whole)],
  ]) {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = text;
    button.title = label;
    button.setAttribute('aria-label', label);
    button.addEventListener('click', act);
    controls.append(button);
  }
  picture.append(controls);
}

document.querySelectorAll('.picture').forEach(makeZoomable);

// On paper nothing can be opened.
addEventListener('beforeprint', () => {
  document.querySelectorAll('details').forEach((details) => { details.open = true; });
});
