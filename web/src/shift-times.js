/**
 * Adds to the time of every row.
 * @param {Float64Array} rows
 * @param {number} stride numbers per row
 * @param {number} timeOffset where the time is in a row
 * @param {number} shift [s]
 */
export function shiftTimes(rows, stride, timeOffset, shift) {
  for (let at = timeOffset; at < rows.length; at += stride) rows[at] += shift;
}
