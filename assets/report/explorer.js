// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later

// The frames: a list of all trials to pick from, and pictures that zoom and pan by their viewBox.
// Without this script the frames stand one below the other, and are still.
const MAX_ZOOM = 32;
const STEP = 1.5;
const LONGEST_LIST = 500;

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

  // Out of the whole picture the wheel scrolls the page.
  svg.addEventListener('wheel', (event) => {
    if (event.deltaY > 0 && view.width === whole.width) return;
    event.preventDefault();
    zoom(Math.exp(-clamp(event.deltaY, -60, 60) / 150), ...fraction(event));
  }, {passive: false});

  svg.addEventListener('dblclick', (event) => zoom(2 * STEP, ...fraction(event)));

  // One finger or the mouse moves the picture, two zoom it.
  const touching = new Map();
  const middle = (points) => [0, 1].map((i) => points.reduce((sum, p) => sum + p[i], 0) / points.length);
  const spread = (points) => points.length < 2 ? 1
    : Math.hypot(points[0][0] - points[1][0], points[0][1] - points[1][1]);
  svg.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    svg.setPointerCapture(event.pointerId);
    touching.set(event.pointerId, fraction(event));
  });
  svg.addEventListener('pointermove', (event) => {
    if (!touching.has(event.pointerId)) return;
    const before = [...touching.values()];
    touching.set(event.pointerId, fraction(event));
    const now = [...touching.values()];
    const [from, to] = [middle(before), middle(now)];
    if (now.length > 1) zoom(spread(now) / Math.max(spread(before), 1e-6), ...to);
    pan(from[0] - to[0], from[1] - to[1]);
  });
  for (const end of ['pointerup', 'pointercancel']) {
    svg.addEventListener(end, (event) => touching.delete(event.pointerId));
  }

  const controls = element('div', {class: 'zoom', role: 'group', 'aria-label': 'Zoom'});
  for (const [text, label, act] of [
    ['+', 'Zoom in (key +, wheel, double click)', () => zoom(STEP)],
    ['−', 'Zoom out (key -)', () => zoom(1 / STEP)],
    ['Reset', 'Show the whole picture (key 0)', () => show(whole)],
  ]) {
    const button = element('button', {type: 'button', title: label, 'aria-label': label}, text);
    button.addEventListener('click', act);
    controls.append(button);
  }
  picture.append(controls);
}

class Explorer {
  constructor(place, data) {
    this.data = data;
    const frames = data.frame.filter((frame) => frame > 0).length;
    const options = (texts) => texts.map((text, i) => element('option', {value: i}, text));
    const any = (text) => element('option', {value: ''}, text);
    this.solver = element('select', {}, ...options(data.solvers));
    this.solver.value = data.lead;
    this.order = element('select', {}, element('option', {value: 'worst'}, 'worst first'),
      element('option', {value: 'best'}, 'best first'), element('option', {value: 'trial'}, 'by trial'));
    this.condition = element('select', {}, any('all'), ...options(data.conditions));
    this.kind = element('select', {}, any('all'), ...options(data.kinds));
    this.extent = element('select', {}, element('option', {value: ''}, `the ${frames} in this page`),
      element('option', {value: 'all'}, `all ${data.trial.length} trials`));
    this.list = element('select', {size: 9, 'aria-label': 'Frames'});
    this.count = element('p', {class: 'note', role: 'status'});
    this.absent = element('div', {class: 'absent', hidden: ''});
    const step = (text, by) => {
      const button = element('button', {type: 'button'}, text);
      button.addEventListener('click', () => this.step(by));
      return button;
    };
    place.append(
      element('div', {class: 'choices'}, ...[['By the error of', this.solver], ['order', this.order],
        ['condition', this.condition], ['what it made of it', this.kind], ['of', this.extent]]
        .map(([text, select]) => element('label', {}, text, select))),
      this.list,
      element('div', {class: 'steps'}, step('← previous', -1), step('next →', 1), this.count),
      this.absent);
    for (const select of [this.solver, this.order, this.condition, this.kind, this.extent]) {
      select.addEventListener('change', () => this.fill());
    }
    this.list.addEventListener('change', () => this.show());
    place.hidden = false;
    this.fill();
    addEventListener('hashchange', () => this.follow());
    this.follow();
  }

  // "2.31°", or why there is none.
  errorText(at) {
    const error = this.data.error[this.solver.value][at];
    return error === null ? this.data.kinds[this.data.kind[this.solver.value][at]] : `${digits(error)}°`;
  }

  chosen() {
    const {data} = this;
    const error = data.error[this.solver.value];
    const kind = data.kind[this.solver.value];
    const found = [...data.trial.keys()].filter((at) =>
      (this.extent.value === 'all' || data.frame[at] > 0) &&
      (this.condition.value === '' || data.condition[at] === Number(this.condition.value)) &&
      (this.kind.value === '' || kind[at] === Number(this.kind.value)));
    const size = (at) => error[at] ?? Infinity;
    const order = {
      worst: (a, b) => size(a) === size(b) ? a - b : size(b) - size(a),
      best: (a, b) => size(a) === size(b) ? a - b : size(a) - size(b),
      trial: (a, b) => data.trial[a] - data.trial[b],
    };
    return found.sort(order[this.order.value]);
  }

  fill() {
    const {data} = this;
    const chosen = this.chosen();
    const listed = chosen.slice(0, LONGEST_LIST);
    this.list.replaceChildren(...listed.map((at) => {
      const condition = data.conditions.length > 1 ? ` · ${data.conditions[data.condition[at]]}` : '';
      const absent = data.frame[at] > 0 ? '' : ' · not in this page';
      return element('option', {value: at},
        `${this.errorText(at)} · trial ${data.trial[at]}${condition}${absent}`);
    }));
    this.list.selectedIndex = 0;
    const more = chosen.length > listed.length ? `, the first ${listed.length} listed` : '';
    const unlisted = data.all > data.trial.length ? ` of ${data.all}; results.csv holds the rest` : '';
    this.count.textContent = `${chosen.length} trial${chosen.length === 1 ? '' : 's'}${more}${unlisted}`;
    this.show();
  }

  step(by) {
    const last = this.list.options.length - 1;
    this.list.selectedIndex = clamp(this.list.selectedIndex + by, 0, last);
    this.show();
  }

  show() {
    const at = this.list.value === '' ? -1 : Number(this.list.value);
    const frame = at < 0 ? 0 : this.data.frame[at];
    document.querySelectorAll('article.frame').forEach((article) => {
      article.classList.toggle('shown', article.id === `frame-${frame}`);
    });
    this.absent.hidden = frame > 0;
    if (frame > 0) return;
    if (at < 0) {
      this.absent.replaceChildren(element('p', {}, 'No trial is like that.'));
      return;
    }
    const trial = this.data.trial[at];
    const command = `sightline study study.toml --shard ${trial}/${this.data.shards} --out trial-${trial}`;
    this.absent.replaceChildren(
      element('p', {}, `Trial ${trial} is not drawn in this page. In the report’s folder this draws it, in a report of its own:`),
      element('pre', {}, element('code', {}, command)));
  }

  // An address such as report.html#frame-3 shows that frame.
  follow() {
    const named = /^#frame-(\d+)$/.exec(location.hash);
    const at = named ? this.data.frame.indexOf(Number(named[1])) : -1;
    if (at < 0) return;
    for (const select of [this.condition, this.kind, this.extent]) select.value = '';
    this.fill();
    this.list.value = at;
    this.show();
  }
}

const explorerPlace = document.querySelector('.explorer');
document.querySelectorAll('.picture').forEach(makeZoomable);
if (explorerPlace) {
  new Explorer(explorerPlace, JSON.parse(document.getElementById('frame-data').textContent));
}
