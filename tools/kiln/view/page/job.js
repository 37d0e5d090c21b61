// Reading and editing of jobs. Every edit returns a new job that shares all other parts with the old one.
//
// A job of one volume has the volume's keys (transferFunction, window, region, clip) beside the picture's; a job of
// several volumes has them in `volumes`.

// Keys that another side of the volume replaces. The projection and the fitted box stay.
const kPlaceKeys = ['view', 'azimuth', 'elevation', 'roll', 'zoom', 'pan', 'eye', 'target', 'up', 'fov', 'height'];
const kMotionKeys = ['turntable', 'keyframes', 'matrices', 'pivot'];

/** Returns the object without the keys whose value is undefined. */
function withoutUndefined(object) {
  return Object.fromEntries(Object.entries(object).filter(([, value]) => value !== undefined));
}

/** Sets keys of the job; undefined removes a key. */
export const withKeys = (job, keys) => withoutUndefined({ ...job, ...keys });

/** Sets keys of an object in the job, such as `image`; an object without keys is removed. */
export function withPart(job, part, keys) {
  const object = withoutUndefined({ ...job[part], ...keys });
  return withKeys(job, { [part]: Object.keys(object).length > 0 ? object : undefined });
}

export const hasSeveralVolumes = (job) => Array.isArray(job.volumes);

/** Returns the object that holds the keys of a volume. */
export const volumeOf = (job, index) => (hasSeveralVolumes(job) ? job.volumes[index] ?? {} : job);

/** Sets keys of a volume. */
export function withVolume(job, index, keys) {
  if (!hasSeveralVolumes(job)) return withKeys(job, keys);
  return { ...job, volumes: job.volumes.map((volume, i) => (i === index ? withKeys(volume, keys) : volume)) };
}

/** Returns the camera of the job if it has a place and a size of its own, else null: a framing is the server's task. */
export function ownCamera(job) {
  const camera = job.camera ?? {};
  if (!camera.eye || !camera.target || !camera.up) return null;
  const parallel = camera.projection === 'orthographic';
  if (parallel ? camera.height === undefined : camera.fov === undefined) return null;
  const { projection = 'perspective', eye, target, up } = camera;
  return parallel ? { projection, eye, target, up, height: camera.height } : { projection, eye, target, up, fov: camera.fov };
}

/** Replaces the still camera; key frames stay. */
export function withCamera(job, camera) {
  const motion = Object.fromEntries(Object.entries(job.camera ?? {}).filter(([key]) => kMotionKeys.includes(key)));
  return { ...job, camera: { ...camera, ...motion } };
}

/** Frames the volume from a side. */
export function withSide(job, side) {
  const others = Object.fromEntries(Object.entries(job.camera ?? {}).filter(([key]) => !kPlaceKeys.includes(key)));
  return { ...job, camera: { ...others, view: side } };
}

export const keyframesOf = (job) => job.camera?.keyframes ?? [];

/** Returns whether anything of the job depends on the frame. */
export function isAnimated(job) {
  const { camera = {} } = job;
  const functions = hasSeveralVolumes(job) ? job.volumes.map((v) => v.transferFunction) : [job.transferFunction];
  return Boolean(camera.keyframes || camera.turntable || camera.matrices || job.lights?.keyframes || job.clip?.keyframes
    || functions.some((fn) => fn?.keyframes));
}

/** Returns the job with its still camera only. */
export function withoutMotion(job) {
  if (!job.camera) return job;
  const still = Object.fromEntries(Object.entries(job.camera).filter(([key]) => !kMotionKeys.includes(key)));
  return withKeys(job, { camera: Object.keys(still).length > 0 ? still : undefined });
}
