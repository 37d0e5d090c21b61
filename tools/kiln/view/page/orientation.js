// Names of directions. The file of a patient names the directions of its axes; other files have x, y and z.

const kOpposite = { L: 'R', R: 'L', P: 'A', A: 'P', S: 'I', I: 'S' };
const kPositive = { RAS: ['R', 'A', 'S'], LPS: ['L', 'P', 'S'] };

/** Returns the letters of the positive ends of the world's axes. */
export const axisNames = (volume) => kPositive[volume.frame] ?? ['x', 'y', 'z'];

/** Returns the letter of the patient's side that is nearest to a direction of the world; "" without a patient. */
export function sideTowards(volume, direction) {
  const names = kPositive[volume.frame];
  if (!names) return '';
  const sizes = direction.map(Math.abs);
  const axis = sizes.indexOf(Math.max(...sizes));
  return direction[axis] > 0 ? names[axis] : kOpposite[names[axis]];
}
