// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Draws the page's charts with Chart.js. Its axes, scales, hovering and sizes are Chart.js'; the
// plugin below adds bands, error bars, boxes and cells, which its core does not have.
const chartData = JSON.parse(document.getElementById('chart-data').textContent);
const allCharts = [];  // what is on show, a place each
const switchedOff = new Set();  // labels of series, in all charts alike
let isPrinting = false;

const DASHES = [[], [7, 4], [2, 3]];
const MARKS = ['circle', 'triangle', 'rect'];
const HOLLOW = 'rectRot';

// On paper as the style sheet has it for print, which does not hold yet when charts are drawn anew.
const ON_PAPER = {ink: '#000000', soft: '#444444', rule: '#bbbbbb', hues: chartData.hues.light};

function theme() {
  if (isPrinting) return ON_PAPER;
  const styles = getComputedStyle(document.documentElement);
  const colour = (name) => styles.getPropertyValue(name).trim();
  return {
    ink: colour('--ink'), soft: colour('--soft'), rule: colour('--rule'),
    hues: isDark() ? chartData.hues.dark : chartData.hues.light,
  };
}

function colourOf(series, look) {
  return series.style < 0 ? look.ink : look.hues[series.style % look.hues.length];
}

function turnOf(series) {
  return series.style < 0 ? 1 : Math.floor(series.style / chartData.hues.light.length) % 3;
}

function withAlpha(colour, alpha) {
  return colour + Math.round(alpha * 255).toString(16).padStart(2, '0');
}

// Three digits, as a reader wants them.
function digits(value) {
  if (value === null || value === undefined) return '–';
  if (value !== 0 && (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e6)) return value.toExponential(2);
  return String(Number(value.toPrecision(4))).replace('-', '−');
}

// The colour of a cell: between the two nearest of the given colours.
function cellColour(value, axis) {
  const at = axis.log ? Math.log(Math.max(value, axis.low) / axis.low) / Math.log(axis.high / axis.low)
    : (value - axis.low) / (axis.high - axis.low || 1);
  const place = Math.min(Math.max(at, 0), 1) * (chartData.cells.length - 1);
  const from = Math.min(Math.floor(place), chartData.cells.length - 2);
  const channel = (hex, i) => parseInt(hex.slice(1 + 2 * i, 3 + 2 * i), 16);
  const mixed = [0, 1, 2].map((i) => Math.round(
    channel(chartData.cells[from], i) * (1 - place + from) +
    channel(chartData.cells[from + 1], i) * (place - from)));
  return `rgb(${mixed.join(' ')})`;
}

const extras = {
  id: 'extras',
  beforeDatasetsDraw(chart) {
    const {ctx, chartArea: area, scales: {x, y}} = chart;
    const spec = chart.config.options.spec;
    ctx.save();
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.width, area.height);
    ctx.clip();
    chart.data.datasets.forEach((dataset, i) => {
      if (!chart.isDatasetVisible(i)) return;
      const {series, borderColor: colour} = dataset;
      if (spec.kind === 'lines' && series.low) drawBand(ctx, series, x, y, colour);
      if (spec.kind === 'points' && series.low) drawBars(ctx, series, x, y, colour);
      if (spec.kind === 'boxes') drawBoxes(ctx, series, x, y, colour);
      if (spec.kind === 'cells') drawCells(ctx, series, x, y, spec);
    });
    ctx.restore();
  },
};

// A value under a logarithmic axis is drawn at its foot.
function height(y, value) {
  return y.getPixelForValue(y.type === 'logarithmic' ? Math.max(value, y.min) : value);
}

function drawBand(ctx, series, x, y, colour) {
  ctx.beginPath();
  series.x.forEach((at, k) => ctx.lineTo(x.getPixelForValue(at), height(y, series.high[k])));
  for (let k = series.x.length - 1; k >= 0; --k) {
    ctx.lineTo(x.getPixelForValue(series.x[k]), height(y, series.low[k]));
  }
  ctx.fillStyle = withAlpha(colour, 0.16);
  ctx.fill();
}

function drawBars(ctx, series, x, y, colour) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  series.x.forEach((at, k) => {
    const px = x.getPixelForValue(at);
    for (const end of [series.low[k], series.high[k]]) {
      ctx.moveTo(px - 3, height(y, end));
      ctx.lineTo(px + 3, height(y, end));
    }
    ctx.moveTo(px, height(y, series.low[k]));
    ctx.lineTo(px, height(y, series.high[k]));
  });
  ctx.stroke();
}

function drawBoxes(ctx, series, x, y, colour) {
  const half = Math.min(0.28 * Math.abs(x.getPixelForValue(1) - x.getPixelForValue(0)), 26);
  series.x.forEach((at, k) => {
    const px = x.getPixelForValue(at);
    const [low, high, least, most, middle] = [
      series.low, series.high, series.least, series.most, series.y].map((v) => height(y, v[k]));
    ctx.strokeStyle = colour;
    ctx.fillStyle = withAlpha(colour, 0.22);
    ctx.lineWidth = 1.5;
    ctx.fillRect(px - half, high, 2 * half, low - high);
    ctx.strokeRect(px - half, high, 2 * half, low - high);
    ctx.beginPath();
    for (const [from, to] of [[low, least], [high, most]]) {
      ctx.moveTo(px, from);
      ctx.lineTo(px, to);
      ctx.moveTo(px - half / 2, to);
      ctx.lineTo(px + half / 2, to);
    }
    ctx.stroke();
    ctx.lineWidth = 3;
    ctx.beginPath();
    ctx.moveTo(px - half, middle);
    ctx.lineTo(px + half, middle);
    ctx.stroke();
  });
}

function drawCells(ctx, series, x, y, spec) {
  const [width, tall] = spec.cell;
  series.x.forEach((at, k) => {
    const left = Math.round(x.getPixelForValue(at - width / 2));
    const right = Math.round(x.getPixelForValue(at + width / 2));
    const top = Math.round(y.getPixelForValue(series.y[k] + tall / 2));
    const foot = Math.round(y.getPixelForValue(series.y[k] - tall / 2));
    ctx.fillStyle = cellColour(series.value[k], spec.value);
    ctx.fillRect(left, top, right - left, foot - top);
  });
}

// What a point says when it is pointed at.
function pointText(spec, series, k) {
  const parts = [`${series.label}: ${digits(series.value ? series.value[k] : series.y[k])}`];
  if (spec.kind === 'boxes') {
    parts.push(`half within ${digits(series.low[k])} to ${digits(series.high[k])}`);
    parts.push(`5 % to 95 %: ${digits(series.least[k])} to ${digits(series.most[k])}`);
  } else if (series.low) {
    parts.push(`95 %: ${digits(series.low[k])} to ${digits(series.high[k])}`);
  }
  if (series.count) parts.push(`${series.count[k]} trials`);
  return parts;
}

function placeText(axis, value) {
  if (axis.names) return axis.names[Math.round(value)];
  return `${axis.label || 'x'}: ${digits(value)}`;
}

function scaleOf(spec, look, isX) {
  const axis = isX ? spec.x : spec.y;
  const scale = {
    type: axis.log ? 'logarithmic' : 'linear',
    title: {display: axis.label !== '', text: axis.label, color: look.soft},
    grid: {color: look.rule, borderColor: look.soft, display: !(isX && axis.names)},
    ticks: {color: look.soft, maxRotation: 60},
  };
  // Chart.js sees the points alone, and not what is drawn about them.
  for (const series of isX ? [] : spec.series) {
    for (const ends of [series.low, series.high, series.least, series.most]) {
      for (const end of ends ?? []) {
        if (end === null) continue;
        scale.suggestedMin = Math.min(scale.suggestedMin ?? end, end);
        scale.suggestedMax = Math.max(scale.suggestedMax ?? end, end);
      }
    }
  }
  if (axis.low !== undefined) scale.min = axis.low;
  if (axis.high !== undefined) scale.max = axis.high;
  if (axis.log) {
    // 1, 2 and 5 of every decade; of many decades the powers alone.
    scale.ticks.callback = function text(value) {
      const lead = Number(value.toExponential()[0]);
      const decades = Math.log10(this.max / this.min);
      return (lead === 1 || (decades < 2.5 && (lead === 2 || lead === 5))) ? digits(value) : '';
    };
  }
  if (axis.names) {
    scale.min = -0.5;
    scale.max = axis.names.length - 0.5;
    scale.afterBuildTicks = (built) => { built.ticks = axis.names.map((_, value) => ({value})); };
    scale.ticks.autoSkip = axis.names.length > 40;
    scale.ticks.callback = (value) => axis.names[value] ?? '';
  }
  return scale;
}

function markOf(series) {
  if (series.paper) return HOLLOW;
  return series.style < 0 ? 'line' : MARKS[turnOf(series)];
}

// The bound is a line, or a dash at each place of words.
function radiusOf(spec, series) {
  if (spec.kind === 'points') return series.style < 0 ? 9 : series.paper ? 5 : 3;
  return spec.kind === 'lines' && series.style >= 0 ? 3 : 0;
}

function datasetOf(spec, series, look) {
  const colour = colourOf(series, look);
  const isJoined = spec.kind === 'lines' || spec.kind === 'steps';
  return {
    label: series.label,
    series,
    data: series.x.map((x, k) => ({x, y: series.y[k]})),
    hidden: switchedOff.has(series.label),
    showLine: isJoined && !series.paper,
    stepped: spec.kind === 'steps' ? 'before' : false,
    borderColor: colour,
    borderWidth: series.paper ? 1.5 : 2,
    borderDash: spec.kind === 'points' ? [] : DASHES[turnOf(series)],
    backgroundColor: series.paper ? 'transparent' : colour,
    pointStyle: markOf(series),
    pointRadius: radiusOf(spec, series),
    pointHoverRadius: spec.kind === 'cells' ? 0 : 5,
    pointHitRadius: 8,
  };
}

function configOf(spec) {
  const look = theme();
  return {
    type: 'scatter',
    data: {datasets: spec.series.map((series) => datasetOf(spec, series, look))},
    plugins: [extras],
    options: {
      spec,
      animation: false,
      responsive: true,
      maintainAspectRatio: false,
      font: {family: getComputedStyle(document.querySelector('figure.chart .plot')).fontFamily},
      interaction: {mode: 'nearest', intersect: false, axis: 'xy'},
      scales: {x: scaleOf(spec, look, true), y: scaleOf(spec, look, false)},
      plugins: {
        legend: {display: false},
        tooltip: {
          displayColors: false,
          callbacks: {
            title: (items) => items.length === 0 ? '' : placeText(spec.x, items[0].parsed.x) +
              (spec.kind === 'cells' ? `, ${placeText(spec.y, items[0].parsed.y)}` : ''),
            label: (item) => pointText(spec, item.dataset.series, item.dataIndex),
          },
        },
      },
    },
  };
}

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// A line and a mark as the series has them.
function swatch(series) {
  const look = theme();
  const colour = colourOf(series, look);
  const turn = turnOf(series);
  const mark = series.paper ? '<path d="M12 1l5 5-5 5-5-5z" fill="none"/>' : series.style < 0 ? ''
    : ['<circle cx="12" cy="6" r="3.2"/>', '<path d="M12 2l4 7h-8z"/>',
      '<rect x="9" y="3" width="6" height="6"/>'][turn];
  const line = series.paper ? '' : `<path d="M0 6H24" stroke-dasharray="${DASHES[turn].join(' ')}"/>`;
  return `<svg viewBox="0 0 24 12" aria-hidden="true" stroke="${colour}" fill="${colour}">` +
    `${line}${mark}</svg>`;
}

function switchSeries(label) {
  if (!switchedOff.delete(label)) switchedOff.add(label);
  allCharts.forEach((place) => place.showSwitches());
}

function legendOf(place) {
  const labels = place.spec.series.map((series) => series.label);
  const buttons = place.spec.series.map((series) => {
    const button = element('button', {type: 'button', 'aria-pressed': !switchedOff.has(series.label)});
    button.innerHTML = swatch(series);
    button.append(series.label);
    button.addEventListener('click', () => switchSeries(series.label));
    return button;
  });
  if (labels.length > 3) {
    const all = element('button', {type: 'button', class: 'all'}, 'all / none');
    all.addEventListener('click', () => {
      const areAllOn = labels.every((label) => !switchedOff.has(label));
      labels.forEach((label) => areAllOn ? switchedOff.add(label) : switchedOff.delete(label));
      allCharts.forEach((other) => other.showSwitches());
    });
    buttons.push(all);
  }
  return buttons;
}

// The colours of cells, from least to most.
function colourBar(axis) {
  const bar = element('div', {class: 'colours'});
  bar.append(`${axis.label}: ${digits(axis.low)}`, element('span', {class: 'ramp', style:
    `background: linear-gradient(to right, ${chartData.cells.join(', ')})`}),
  digits(axis.high), axis.log ? ' (logarithmic)' : '');
  return bar;
}

const LONGEST_TABLE = 25;  // points of a series

function tableOf(spec) {
  const columns = [['y', spec.kind === 'boxes' ? 'median' : spec.y.label || 'value'], ['value', spec.value?.label],
    ['low', spec.kind === 'boxes' ? '25 %' : '95 % from'], ['high', spec.kind === 'boxes' ? '75 %' : 'to'],
    ['least', '5 %'], ['most', '95 %'], ['count', 'trials']]
    .filter(([key]) => spec.series.some((series) => series[key]));
  const head = element('tr', {}, ...['Series', spec.x.label || 'at', ...columns.map((c) => c[1])]
    .map((text) => element('th', {scope: 'col'}, text)));
  const body = element('tbody');
  for (const series of spec.series) {
    const step = Math.max(1, Math.ceil(series.x.length / LONGEST_TABLE));
    series.x.forEach((at, k) => {
      if (spec.kind === 'steps' && k % step !== 0 && k !== series.x.length - 1) return;
      body.append(element('tr', {}, element('th', {scope: 'row'}, series.label),
        element('td', {}, spec.x.names ? spec.x.names[Math.round(at)] : digits(at)),
        ...columns.map(([key]) => element('td', {}, series[key] ? digits(series[key][k]) : ''))));
    });
  }
  return element('div', {class: 'scroll', role: 'region', tabindex: '0', 'aria-label': `${spec.title}, data`},
    element('table', {}, element('caption', {}, element('span', {}, `${spec.title}. The whole data: figures/${spec.id}.dat`)),
      element('thead', {}, head), body));
}

class ChartPlace {
  constructor(figure) {
    this.figure = figure;
    this.canvas = figure.querySelector('canvas');
    this.specs = chartData.charts.filter((spec) => spec.group === figure.dataset.group);
    this.legend = element('div', {class: 'series', role: 'group', 'aria-label': 'Series on show'});
    this.data = element('details', {class: 'data'}, element('summary', {}, 'Data as a table'));
    this.data.addEventListener('toggle', () => this.fillTable());
    figure.append(this.legend, this.data);
    if (this.specs.length > 1) this.addChoice();
    this.show(this.specs[0]);
  }

  addChoice() {
    const select = element('select', {'aria-label': `${this.specs[0].title}: of`},
      ...this.specs.map((spec, i) => element('option', {value: i}, spec.option)));
    select.addEventListener('change', () => this.show(this.specs[select.value]));
    this.figure.querySelector('figcaption').append(' ', select);
  }

  show(spec) {
    this.spec = spec;
    this.canvas.dataset.chart = spec.id;
    this.draw();
    this.fillTable();
  }

  draw() {
    this.chart?.destroy();
    this.chart = new Chart(this.canvas, configOf(this.spec));
    const isOfCells = this.spec.kind === 'cells';
    this.legend.replaceChildren(...(isOfCells ? [colourBar(this.spec.value)] : legendOf(this)));
    this.canvas.dataset.ready = this.spec.series.length;
  }

  showSwitches() {
    if (this.spec.kind === 'cells') return;
    this.spec.series.forEach((series, i) => {
      this.chart.setDatasetVisibility(i, !switchedOff.has(series.label));
      this.legend.children[i].setAttribute('aria-pressed', !switchedOff.has(series.label));
    });
    this.chart.update();
  }

  fillTable() {
    this.data.querySelector('.scroll')?.remove();
    if (this.data.open) this.data.append(tableOf(this.spec));
  }
}

document.querySelectorAll('figure.chart').forEach((figure) => allCharts.push(new ChartPlace(figure)));

function redrawCharts() {
  allCharts.forEach((place) => place.draw());
}

onThemeChange(redrawCharts);
addEventListener('beforeprint', () => {
  isPrinting = true;
  redrawCharts();
});
addEventListener('afterprint', () => {
  isPrinting = false;
  redrawCharts();
});
