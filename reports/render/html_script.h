#pragma once

#include <string_view>

/// @file
/// The script of HTML reports. It adds to a page that is complete without it: values under the mouse, zoom
/// and switched curves in figures, sorted and filtered tables, and folds that open for links and for
/// printing. The figures are the drawn ones (panel_data.h says what comes with each); nothing is fetched or
/// stored.

namespace credence::internal {

inline constexpr std::string_view kPageScript = R"js(
'use strict';
document.addEventListener('DOMContentLoaded', () => {
  const all = (selector, root) => Array.from((root || document).querySelectorAll(selector));

  // ---- Folds
  const reveal = () => {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    for (let e = target; e; e = e.parentElement) if (e.tagName === 'DETAILS') e.open = true;
    target.scrollIntoView();
  };
  window.addEventListener('hashchange', reveal);
  document.addEventListener('click', event => {
    const link = event.target.closest('a[href^="#"]');
    if (link && link.getAttribute('href') === location.hash) reveal();
  });
  reveal();
  let closed = [];
  window.addEventListener('beforeprint', () => {
    closed = all('details:not([open])');
    closed.forEach(d => { d.open = true; });
  });
  window.addEventListener('afterprint', () => closed.forEach(d => { d.open = false; }));

  // ---- Contents: the section in view, and all folds at once
  const nav = document.querySelector('nav');
  if (nav) {
    const entries = new Map();
    all('a', nav).forEach(a => {
      const section = document.getElementById(a.getAttribute('href').slice(1));
      if (section) entries.set(section, a);
    });
    const mark = () => {
      let current = null;
      entries.forEach((a, section) => { if (section.getBoundingClientRect().top < 120) current = a; });
      entries.forEach(a => a.classList.toggle('here', a === current));
    };
    window.addEventListener('scroll', mark, {passive: true});
    mark();
    if (all('details').length > 1) {
      const button = document.createElement('button');
      button.type = 'button';
      const folds = () => all('main details');
      const name = () => { button.textContent = folds().every(d => d.open) ? 'Fold all' : 'Unfold all'; };
      button.addEventListener('click', () => {
        const open = !folds().every(d => d.open);
        folds().forEach(d => { d.open = open; });
        name();
      });
      document.addEventListener('toggle', name, true);
      name();
      nav.append(button);
    }
  }

  // ---- Tables: sorted by a column, filtered by words
  const plain = text => text.replace(/[\u2007\u2008]/g, '').replace(/\u2212/g, '-').trim();
  // The number that is meant, as of "< 1e-12", "> 100 %", "25 ms" and "3 MB"; NaN for words.
  const units = {ns: 1e-9, '\u00b5s': 1e-6, ms: 1e-3, min: 60, h: 3600, kB: 1e3, MB: 1e6, GB: 1e9};
  const number = text => {
    const [size, unit] = text.replace(/^[<>\u00d7\u00b1]\s*/, '').replace('\u221e', 'Infinity').split(/\s+/);
    return parseFloat(size) * (units[unit] || 1);
  };
  document.addEventListener('copy', event => {
    const text = String(getSelection());
    if (!/[\u2007\u2008\u2212]/.test(text)) return;
    event.clipboardData.setData('text/plain', text.replace(/[\u2007\u2008]/g, '').replace(/\u2212/g, '-'));
    event.preventDefault();
  });
  all('.table table').forEach(table => {
    const body = table.tBodies[0], rows = Array.from(body.rows);
    if (rows.length < 4) return;
    const key = (row, i) => plain(row.cells[i].textContent);
    all('thead th', table).forEach(th => {
      const i = th.cellIndex, button = document.createElement('button');
      button.type = 'button';
      button.title = 'sort by this column';
      button.append(...th.childNodes);
      th.append(button);
      button.addEventListener('click', () => {
        const up = th.getAttribute('aria-sort') !== 'ascending';
        all('thead th', table).forEach(t => t.removeAttribute('aria-sort'));
        th.setAttribute('aria-sort', up ? 'ascending' : 'descending');
        const sign = up ? 1 : -1;
        rows.slice().sort((a, b) => {
          const s = key(a, i), t = key(b, i), x = number(s), y = number(t);
          if (isNaN(x) !== isNaN(y)) return isNaN(x) ? 1 : -1;
          return sign * (isNaN(x) ? s.localeCompare(t) : x - y);
        }).forEach(row => body.append(row));
      });
    });
    if (rows.length < 20) return;
    const field = document.createElement('input');
    field.type = 'search';
    field.placeholder = 'rows with these words';
    field.setAttribute('aria-label', 'show rows with these words');
    field.addEventListener('input', () => {
      const words = field.value.toLowerCase().split(/\s+/);
      rows.forEach(row => {
        const text = plain(row.textContent).toLowerCase();
        row.hidden = !words.every(w => text.includes(w));
      });
    });
    table.closest('.table').prepend(field);
  });

  // ---- Figures
  const live = document.createElement('div');
  live.className = 'live';
  live.setAttribute('aria-live', 'polite');
  document.body.append(live);
  const tip = document.createElement('div');
  tip.className = 'tip';
  tip.hidden = true;
  document.body.append(tip);
  window.addEventListener('scroll', () => { tip.hidden = true; }, {passive: true});

  const digits = (v, n) => {
    if (v === null || v === undefined || !isFinite(v)) return '\u2013';
    const size = Math.abs(v);
    const text = size !== 0 && (size < 1e-4 || size >= 1e6) ? v.toExponential(n - 1) : String(+v.toPrecision(n));
    return text.replace('-', '\u2212');
  };
  const unit = label => { const m = /\(([^()]*)\)\s*$/.exec(label); return m ? ' ' + m[1] : ''; };
  const bare = label => label.replace(/\s*\([^()]*\)\s*$/, '');

  all('.panel').forEach(panel => {
    const svg = panel.querySelector('svg'), source = panel.querySelector('script');
    if (!svg || !source) return;
    const data = JSON.parse(source.textContent);
    const make = (name, attributes, parent) => {
      const e = document.createElementNS(svg.namespaceURI, name);
      for (const a in attributes) e.setAttribute(a, attributes[a]);
      if (parent) parent.append(e);
      return e;
    };
    const [left, right, top, bottom] = data.box;
    const columns = data.columns.map(c => c.n === undefined ? c :
        Array.from({length: c.n}, (_, i) => c.from + i * c.by));
    const series = data.series.map(s => Object.assign({}, s, {x: columns[s.x]}));
    const hidden = new Set();
    const scale = ([low, high, log], from, to) => {
      const f = log ? Math.log : v => v, a = f(low), b = f(high);
      return {
        at: v => v === null || (log && v <= 0) ? NaN : from + (f(v) - a) / (b - a) * (to - from),
        value: p => { const t = a + (p - from) / (to - from) * (b - a); return log ? Math.exp(t) : t; }
      };
    };
    let xRange = data.x, yRange = data.y, X, Y;
    const rescale = () => { X = scale(xRange, left, right); Y = scale(yRange, bottom, top); };
    rescale();

    svg.setAttribute('role', 'group');
    svg.setAttribute('tabindex', '0');
    svg.setAttribute('aria-label', data.title + '. Arrow keys show values, plus and minus zoom.');
    const overlay = make('g', {'class': 'overlay'}, svg);
    const rule = make('line', {y1: top, y2: bottom, 'class': 'rule', visibility: 'hidden'}, overlay);
    const dots = make('g', {}, overlay);
    const frame = make('rect', {x: left, y: top, width: right - left, height: bottom - top, fill: 'none',
      'pointer-events': 'all', 'class': 'catch'}, overlay);
    const drag = make('rect', {'class': 'drag', visibility: 'hidden'}, overlay);

    // Where a pointer is, in the units of the drawing.
    const place = event => {
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      return [p.x, p.y];
    };
    const shown = s => !hidden.has(s.i);
    const line = (s, k) => s.l ? `${digits(s.l[k], 4)} \u2026 ${digits(s.u[k], 4)}` : '';
    const nearest = (s, x, y) => {
      let best = -1, least = Infinity;
      for (let k = 0; k < s.x.length; ++k) {
        const px = X.at(s.x[k]), py = s.y && data.mode === 'near' ? Y.at(s.y[k]) : y;
        const d = Math.hypot(px - x, py - y);
        if (d < least) { least = d; best = k; }
      }
      return [best, least];
    };
    const rowsAt = (x, y) => {
      const rows = [];
      let head = '', at = null;
      if (data.mode === 'cells') {
        const c = data.cells, col = c.xe.findIndex((e, k) => x >= X.at(e) && x < X.at(c.xe[k + 1]));
        const row = c.ye.findIndex((e, k) => y <= Y.at(e) && y > Y.at(c.ye[k + 1]));
        if (col < 0 || row < 0) return null;
        const xs = c.xn ? c.xn[col] : digits(c.x[col], 5), ys = c.yn ? c.yn[row] : digits(c.y[row], 5);
        return {head: `${bare(data.xLabel)} ${xs}, ${bare(data.yLabel)} ${ys}`, at: null,
          rows: [{n: bare(data.valueLabel), v: digits(c.v[row][col], 4) + unit(data.valueLabel)}], dots: []};
      }
      if (data.mode === 'near') {
        let best = null;
        for (const s of series) {
          if (!shown(s) || !s.y) continue;
          const [k, d] = nearest(s, x, y);
          if (k >= 0 && (!best || d < best.d)) best = {s, k, d};
        }
        if (!best || best.d > 40) return null;
        const {s, k} = best;
        return {head: s.n, at: null, dots: [[X.at(s.x[k]), Y.at(s.y[k]), s.c]], rows: [
          {n: bare(data.xLabel), v: digits(s.x[k], 5) + unit(data.xLabel)},
          {n: bare(data.yLabel), v: digits(s.y[k], 5) + unit(data.yLabel)}]};
      }
      for (const s of series) {
        if (!shown(s) || s.x.length === 0) continue;
        const [k] = nearest(s, x, y);
        if (k >= 0 && (at === null || Math.abs(X.at(s.x[k]) - x) < Math.abs(X.at(at) - x))) at = s.x[k];
      }
      if (at === null) return null;
      const spots = [];
      for (const s of series) {
        if (!shown(s)) continue;
        const [k] = nearest(s, X.at(at), 0);
        if (k < 0 || s.x[k] !== at) continue;
        const band = line(s, k), y = s.y ? digits(s.y[k], 4) : '';
        if (!band && (y === '\u2013')) continue;
        rows.push({n: s.n, c: s.c, v: y + (y && band ? ` (${band})` : band) + unit(data.yLabel)});
        if (s.y && Y.at(s.y[k]) >= top - 1 && Y.at(s.y[k]) <= bottom + 1) spots.push([X.at(at), Y.at(s.y[k]), s.c]);
      }
      return {head: `${bare(data.xLabel)} ${digits(at, 6)}${unit(data.xLabel)}`, at, rows, dots: spots};
    };
    let cursor = null;
    const hide = () => {
      tip.hidden = true;
      rule.setAttribute('visibility', 'hidden');
      dots.replaceChildren();
    };
    const show = (x, y, clientX, clientY) => {
      const found = rowsAt(x, y);
      if (!found) return hide();
      cursor = [found.at === null ? x : X.at(found.at), y];
      rule.setAttribute('visibility', found.at === null ? 'hidden' : 'visible');
      rule.setAttribute('x1', cursor[0]);
      rule.setAttribute('x2', cursor[0]);
      dots.replaceChildren(...found.dots.map(([cx, cy, c]) => make('circle', {cx, cy, r: 3.5, fill: c})));
      tip.replaceChildren();
      const head = document.createElement('b');
      head.textContent = found.head;
      tip.append(head);
      for (const row of found.rows.slice(0, 16)) {
        const e = document.createElement('div'), name = document.createElement('span');
        name.textContent = row.n;
        if (row.c) name.style.borderColor = row.c;
        e.append(name, ' ' + row.v);
        tip.append(e);
      }
      tip.hidden = false;
      const r = tip.getBoundingClientRect();
      const tx = clientX + 16 + r.width > innerWidth ? clientX - 16 - r.width : clientX + 16;
      tip.style.left = Math.max(4, tx) + 'px';
      tip.style.top = Math.max(4, Math.min(clientY + 12, innerHeight - r.height - 4)) + 'px';
      return found;
    };
    const showAt = (x, y) => {
      const p = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
      const found = show(x, y, p.x, p.y);
      if (found) live.textContent = found.head + ': ' + found.rows.map(r => r.n + ' ' + r.v).join(', ');
    };

    // ---- Zoom: the drawn curves are stretched, the ticks are new
    let zoomed = null;
    const ticksOf = ([low, high, log], wanted) => {
      const ticks = [];
      if (log && high / low > 30) {
        for (let e = Math.ceil(Math.log10(low)); e <= Math.floor(Math.log10(high)); ++e) ticks.push(10 ** e);
        const every = Math.ceil(ticks.length / wanted);
        return ticks.filter((_, k) => k % every === 0);
      }
      const raw = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(raw));
      const step = [1, 2, 5, 10].find(m => m * power >= raw) * power;
      for (let k = Math.ceil(low / step); k * step <= high; ++k) ticks.push(k * step);
      return ticks;
    };
    const draw = () => {
      rescale();
      const plot = svg.querySelector('.plot');
      if (!zoomed) {
        zoomed = make('svg', {x: left, y: top, width: right - left, height: bottom - top,
          preserveAspectRatio: 'none', overflow: 'hidden', 'class': 'zoom'});
        plot.before(zoomed);
        zoomed.append(plot);
      }
      const whole = [scale(data.x, left, right), scale(data.y, bottom, top)];
      const a = whole[0].at(xRange[0]), b = whole[0].at(xRange[1]);
      const c = whole[1].at(yRange[1]), d = whole[1].at(yRange[0]);
      zoomed.setAttribute('viewBox', `${a} ${c} ${b - a} ${d - c}`);
      const back = xRange === data.x && yRange === data.y;
      all('.ticks, .grid', svg).forEach(g => { g.style.display = back ? '' : 'none'; });
      all('.new-ticks', svg).forEach(g => g.remove());
      svg.classList.toggle('is-zoomed', !back);
      if (back) return;
      const g = make('g', {'class': 'new-ticks'});
      zoomed.before(g);
      for (const v of ticksOf(xRange, 5)) {
        const x = X.at(v);
        make('path', {d: `M${x} ${top}V${bottom}`, stroke: '#e6e6e6', 'stroke-width': 0.7}, g);
        make('text', {x, y: bottom + 15, 'text-anchor': 'middle'}, g).textContent = digits(v, 6);
      }
      for (const v of ticksOf(yRange, 5)) {
        const y = Y.at(v);
        make('path', {d: `M${left} ${y}H${right}`, stroke: '#e6e6e6', 'stroke-width': 0.7}, g);
        make('text', {x: left - 8, y: y + 4, 'text-anchor': 'end'}, g).textContent = digits(v, 4);
      }
    };
    const zoomTo = (a, b, c, d) => {
      const x = [X.value(a), X.value(b), data.x[2]], y = [Y.value(d), Y.value(c), data.y[2]];
      const span = ([low, high, log], [l, h]) => log ? Math.log(h / l) / Math.log(high / low) : (h - l) / (high - low);
      if (span(data.x, x) < 1e-5 || span(data.y, y) < 1e-5) return;
      xRange = x;
      yRange = y;
      hide();
      draw();
    };
    const reset = () => { xRange = data.x; yRange = data.y; hide(); if (zoomed) draw(); };
    const about = (factor) => {
      const [x, y] = cursor || [(left + right) / 2, (top + bottom) / 2];
      const l = x - (x - left) * factor, r = x + (right - x) * factor;
      const t = y - (y - top) * factor, b = y + (bottom - y) * factor;
      if (factor > 1 && X.value(l) <= data.x[0] && X.value(r) >= data.x[1]) return reset();
      zoomTo(l, r, t, b);
    };

    let start = null;
    frame.addEventListener('pointermove', event => {
      const [x, y] = place(event);
      if (!start) return show(x, y, event.clientX, event.clientY);
      const clamp = (v, low, high) => Math.max(low, Math.min(high, v));
      const ex = clamp(x, left, right), ey = clamp(y, top, bottom);
      drag.setAttribute('visibility', 'visible');
      drag.setAttribute('x', Math.min(start[0], ex));
      drag.setAttribute('y', Math.min(start[1], ey));
      drag.setAttribute('width', Math.abs(ex - start[0]));
      drag.setAttribute('height', Math.abs(ey - start[1]));
    });
    frame.addEventListener('pointerdown', event => {
      if (event.pointerType === 'mouse' && event.button === 0) {
        start = place(event);
        frame.setPointerCapture(event.pointerId);
        hide();
      } else {
        const [x, y] = place(event);
        show(x, y, event.clientX, event.clientY);
      }
    });
    frame.addEventListener('pointerup', () => {
      if (start && drag.getAttribute('visibility') === 'visible') {
        const x = +drag.getAttribute('x'), y = +drag.getAttribute('y');
        const w = +drag.getAttribute('width'), h = +drag.getAttribute('height');
        if (w > 8 && h > 8) zoomTo(x, x + w, y, y + h);
      }
      start = null;
      drag.setAttribute('visibility', 'hidden');
    });
    frame.addEventListener('pointerleave', event => { if (event.pointerType === 'mouse' && !start) hide(); });
    frame.addEventListener('dblclick', reset);
    svg.addEventListener('blur', hide);
    svg.addEventListener('keydown', event => {
      if (event.target !== svg) return;
      const go = {ArrowLeft: -1, ArrowRight: 1}[event.key];
      if (go) {
        const longest = series.filter(shown).reduce((m, s) => !m || s.x.length > m.x.length ? s : m, null);
        if (!longest || data.mode === 'cells') return;
        const [k] = cursor ? nearest(longest, cursor[0], cursor[1]) : [go > 0 ? -1 : longest.x.length];
        const next = Math.max(0, Math.min(longest.x.length - 1, k + go));
        showAt(X.at(longest.x[next]), longest.y ? Y.at(longest.y[next]) : (top + bottom) / 2);
      } else if (event.key === '+' || event.key === '=') about(0.5);
      else if (event.key === '-') about(2);
      else if (event.key === 'Escape' || event.key === '0') reset();
      else return;
      event.preventDefault();
    });

    // ---- Curves are switched by their entries in the legend, which is that of the next panels without one
    const named = Object.keys(data.parts).map(Number);
    panel.turn = (k, off) => {
      const i = named[k];
      if (i === undefined) return;
      if (off) hidden.add(i); else hidden.delete(i);
      all(data.parts[i].map(k => '.series.s' + k).join(','), svg).forEach(g => { g.style.display = off ? 'none' : ''; });
      hide();
    };
    all('.key', svg).forEach(entry => {
      const i = +entry.classList[1].slice(1), k = named.indexOf(i);
      entry.setAttribute('role', 'button');
      entry.setAttribute('tabindex', '0');
      entry.setAttribute('aria-pressed', 'true');
      const flip = () => {
        const off = !hidden.has(i);
        panel.turn(k, off);
        for (let next = panel.nextElementSibling; next && next.turn && !next.querySelector('.key'); next = next.nextElementSibling) next.turn(k, off);
        entry.setAttribute('aria-pressed', String(!off));
      };
      entry.addEventListener('click', flip);
      entry.addEventListener('keydown', event => {
        if (event.key !== 'Enter' && event.key !== ' ') return;
        event.preventDefault();
        flip();
      });
    });
  });
});
)js";

}  // namespace credence::internal
