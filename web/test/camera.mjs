// Where the camera of a scene file sees a place.

/** A function from a place in m and the size of the picture to a column and a row. */
export function cameraOf(toml) {
  const value = (key) => JSON.parse(new RegExp(`^${key} = (.+)$`, "m").exec(toml)[1]);
  const eye = value("position");
  const forward = unit(minus(value("look_at"), eye));
  const right = unit(cross(forward, [0, 0, 1]));
  const up = cross(right, forward);
  const half = Math.tan((value("vertical_fov_deg") * Math.PI) / 360);
  return (place, [width, height]) => {
    const way = minus(place, eye);
    const scale = height / (2 * half * dot(way, forward));
    return [width / 2 + scale * dot(way, right), height / 2 - scale * dot(way, up)];
  };
}

function minus(one, other) {
  return one.map((value, axis) => value - other[axis]);
}

function dot(one, other) {
  return one.reduce((sum, value, axis) => sum + value * other[axis], 0);
}

function cross([a, b, c], [x, y, z]) {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

function unit(vector) {
  return vector.map((value) => value / Math.sqrt(dot(vector, vector)));
}
