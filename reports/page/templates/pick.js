"use strict";
// The cheapest measured run within bounds, by the same rules as `mbs-ref pick` (benchmarks/pick.py).
const within = (value, limit) => limit === null || (value !== null && value <= limit);
const least = (rows, key) => rows.reduce((best, row) => (best === null || (row[key] ?? Infinity) < (best[key] ?? Infinity) ? row : best), null);

// rows: {engine, method, error, floor, compliance, ms}; bounds: {error, compliance, ms}, null where there is no bound
function choose(rows, bounds) {
  const floor = Math.max(0, ...rows.map((row) => row.floor));
  if (bounds.error !== null && bounds.error < floor) return { why: "floor", floor };
  const errorOk = (row) => within(row.error, bounds.error), gapOk = (row) => within(row.compliance, bounds.compliance);
  const reached = rows.filter((row) => errorOk(row) && gapOk(row)).sort((a, b) => a.ms - b.ms);
  const fit = reached.filter((row) => within(row.ms, bounds.ms));
  if (!fit.length) {
    if (!rows.length) return { why: "nothing" };
    if (reached.length) return { why: "budget", near: reached[0] };
    const close = rows.filter(errorOk);
    return close.length ? { why: "compliance", near: least(close, "compliance"), count: close.length } : { why: "error", near: least(rows, "error") };
  }
  const best = fit[0], second = fit.find((row) => row.engine !== best.engine) ?? fit.find((row) => row.method !== best.method) ?? null;
  const cheaper = rows.filter((row) => row.ms < best.ms);
  const loose = least(cheaper.filter(errorOk), "compliance"), far = least(cheaper.filter(gapOk), "error");
  const limit = loose ? { bound: "compliance", cheaper: loose } : far ? { bound: "error", cheaper: far } : null;
  return { best, second, margin: second ? second.ms / best.ms : null, limit };
}
