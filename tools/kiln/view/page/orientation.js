// Names of directions. The file of a patient names the directions of its axes; other files have x, y and z.

const kPositive = { RAS: ['R', 'A', 'S'], LPS: ['L', 'P', 'S'] };

/** Returns the letters of the positive ends of the world's axes. */
export const axisNames = (volume) => kPositive[volume.frame] ?? ['x', 'y', 'z'];
