"use strict";
// The path and the arm in space, drawn by three.js: millimetres, z up, the origin of the robot's base frame.
const makeSpace = (page) => {
  const three = libraries, box = page.$("space");
  let renderer = null, labels, scene, camera, controls, content, shown = null, arm = null, marker, line = null, chosenLine = null;
  let by = "time", now = 0, chosen = -1, waiting = false, size = [0, 0];

  const colour = (name) => new three.Color(page.css(name) || "#888");
  const vector = (values) => new three.Vector3(...values);

  const render = () => {
    if (waiting || !renderer) return;
    waiting = true;
    requestAnimationFrame(paint);
  };
  const paint = () => {
    waiting = false;
    if (!renderer) return;
    renderer.render(scene, camera);
    labels.render(scene, camera);
  };

  /** False where the browser draws nothing in space. */
  const start = () => {
    if (renderer) return true;
    if (!document.createElement("canvas").getContext("webgl2")) { page.$("flat").hidden = false; return false; }
    renderer = new three.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true }); // paper shows the buffer
    renderer.debug.checkShaderErrors = false; // to ask for them waits for the graphics card
    labels = new three.CSS2DRenderer();
    labels.domElement.className = "labels";
    box.append(renderer.domElement, labels.domElement);
    scene = new three.Scene();
    camera = new three.PerspectiveCamera(35, 1, 1, 1e6);
    camera.up.set(0, 0, 1);
    const lamp = new three.DirectionalLight(0xffffff, 1.8);
    lamp.position.set(0.5, 1, 1);
    camera.add(lamp);
    scene.add(new three.AmbientLight(0xffffff, 1.1), camera);
    controls = new three.OrbitControls(camera, renderer.domElement);
    controls.addEventListener("change", render);
    renderer.domElement.style.touchAction = "pan-y"; // a finger scrolls the page past the picture
    hands();
    return true;
  };

  const resize = (wide = box.clientWidth, high = box.clientHeight) => {
    if (!renderer || !wide || (size[0] === wide && size[1] === high)) return;
    size = [wide, high];
    renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    renderer.setSize(wide, high);
    labels.setSize(wide, high);
    camera.aspect = wide / high;
    camera.updateProjectionMatrix();
    paint();
  };

  const clear = () => {
    content?.traverse((part) => { part.geometry?.dispose(); part.material?.dispose(); if (part.isCSS2DObject) part.element.remove(); });
    content?.removeFromParent();
    line = arm = null;
  };

  const show = (next, keep = false) => {
    const again = keep && shown !== null;
    shown = next;
    if (!again) { chosen = -1; now = 0; }
    if (!shown.d.path || !start()) return;
    clear();
    content = new three.Group();
    scene.add(content);
    const { path } = shown.d, extent = new three.Box3();
    for (let i = 0; i < path.x.length; i++) extent.expandByPoint(vector([path.x[i], path.y[i], path.z[i]]));
    const ofPath = extent.clone(), reach = Math.max(50, extent.getSize(new three.Vector3()).length());
    arm = shown.d.arm ? makeArm(shown.d.arm) : null;
    if (arm) { content.add(arm.root); arm.extend(extent); }
    const around = floor(extent);
    marker = new three.Mesh(new three.SphereGeometry(Math.max(reach / 110, 2), 20, 14), new three.MeshLambertMaterial({ color: colour("red") }));
    chosenLine = thick([], 6, { color: colour("ink") }); // one for all: another would have its shader compiled
    content.add(marker, chosenLine);
    colours();
    resize();
    shown.corners = { whole: [...cornersOf(extent), ...around], path: cornersOf(ofPath) };
    if (!again) fit("whole");
    choose(chosen);
    at(now);
  };

  const cornersOf = ({ min, max }) =>
    [0, 1, 2, 3, 4, 5, 6, 7].map((n) => vector([n & 1 ? max.x : min.x, n & 2 ? max.y : min.y, n & 4 ? max.z : min.z]));
  const fit = (what) => {
    if (!shown?.corners) return;
    const corners = shown.corners[what], { min, max } = new three.Box3().setFromPoints(corners);
    const centre = min.clone().add(max).multiplyScalar(0.5), radius = Math.max(10, max.distanceTo(min) / 2);
    const view = vector([0.62, -0.68, 0.42]).normalize();
    camera.near = radius / 200; camera.far = radius * 200;
    camera.updateProjectionMatrix();
    let far = radius * 4;
    for (let turn = 0; turn < 8; turn++) { // until the corners are in the middle, and just inside
      camera.position.copy(centre).addScaledVector(view, far);
      controls.target.copy(centre);
      controls.update();
      camera.updateMatrixWorld();
      const seen = new three.Box3().setFromPoints(corners.map((corner) => corner.clone().project(camera)));
      const middle = seen.getCenter(new three.Vector3()), size = seen.getSize(new three.Vector3()), high = far * Math.tan((camera.fov * Math.PI) / 360);
      const across = new three.Vector3().setFromMatrixColumn(camera.matrixWorld, 0), up = new three.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
      centre.addScaledVector(across, middle.x * high * camera.aspect).addScaledVector(up, middle.y * high);
      far *= 0.25 + 0.75 * (Math.max(size.x, size.y) / 2 / 0.9);
    }
    render();
  };

  const label = (text, place, name = "") => {
    const element = document.createElement("span");
    element.textContent = text;
    element.className = name;
    element.ariaHidden = true;
    const object = new three.CSS2DObject(element);
    object.position.set(...place);
    content.add(object);
  };
  const lines = (points, tone) => {
    const geometry = new three.BufferGeometry().setFromPoints(points.map(vector));
    content.add(new three.LineSegments(geometry, new three.LineBasicMaterial({ color: colour(tone) })));
  };

  /** The floor as a grid, the axes with millimetres; the ends of what is drawn. */
  const floor = (extent) => {
    const known = shown.d.arm && shown.d.arm.floor !== null, level = known ? shown.d.arm.floor : 0;
    extent.expandByPoint(vector([0, 0, level]));
    const far = extent.getSize(new three.Vector3()), step = page.round(Math.max(far.x, far.y, far.z) / 9);
    const from = (v) => Math.floor(v / step) * step, to = (v) => Math.ceil(v / step) * step;
    const [x0, x1, y0, y1] = [from(extent.min.x), to(extent.max.x), from(extent.min.y), to(extent.max.y)];
    const [z0, z1] = [Math.min(level, from(extent.min.z)), to(extent.max.z)], grid = [], away = step * 0.35;
    for (let x = x0; x <= x1 + 1e-6; x += step) { grid.push([x, y0, level], [x, y1, level]); label(x, [x, y0 - away, level]); }
    for (let y = y0; y <= y1 + 1e-6; y += step) { grid.push([x0, y, level], [x1, y, level]); label(y, [x1 + away, y, level]); }
    lines(grid, "grid");
    const rule = [[x0, y1, z0], [x0, y1, z1]];
    for (let z = from(z0); z <= z1 + 1e-6; z += step) { rule.push([x0, y1, z], [x0 - away / 2, y1, z]); label(z, [x0 - away, y1, z]); }
    lines(rule, "frame");
    label("X mm", [(x0 + x1) / 2, y0 - 4 * away, level], "axis");
    label("Y mm", [x1 + 4 * away, (y0 + y1) / 2, level], "axis");
    label("Z mm", [x0, y1, z1 + away], "axis");
    for (const [tone, end] of [["red", [step, 0, 0]], ["olive", [0, step, 0]], ["blue", [0, 0, step]]]) lines([[0, 0, 0], end], tone);
    page.$("scale").textContent = "Grid " + step + " mm, " + (known ? "on the floor." : "at z = 0 of the base frame: the height of the floor is not known.")
      + (arm ? "" : " The arm is not drawn: its geometry or its axes are not known.");
    return [[x0, y0 - away, level], [x1 + away, y0 - away, level], [x1 + away, y1, level], [x0, y1, z0], [x0, y1, z1 + away]].map(vector);
  };

  const turned = (direction, degrees) => new three.Quaternion().setFromAxisAngle(vector(direction), (degrees * Math.PI) / 180);
  const UP = new three.Vector3(0, 1, 0); // along which three.js makes cylinders

  /** A wire figure of the chain: the frames' origins, joined by cylinders; thinner towards the flange. */
  const makeArm = (data) => {
    const root = new three.Group(), pivots = [], skin = new three.MeshLambertMaterial({ color: colour("arm") });
    const joint = new three.MeshLambertMaterial({ color: colour("joint") });
    const length = data.joints.reduce((sum, j) => sum + Math.hypot(...j.offset), Math.hypot(...data.flange)) || 1;
    const rod = (from, to, radius, material) => {
      const way = to.clone().sub(from), part = new three.Mesh(new three.CylinderGeometry(radius, radius, 1, 20), material);
      part.position.copy(from).addScaledVector(way, 0.5);
      part.quaternion.setFromUnitVectors(UP, way.clone().normalize());
      part.scale.y = Math.max(way.length(), 1e-3);
      return part;
    };
    const nothing = vector([0, 0, 0]);
    let parent = root;
    if (data.floor !== null && data.floor < 0) root.add(rod(vector([0, 0, data.floor]), nothing, length * 0.045, skin));
    data.joints.forEach((j, i) => {
      const offset = vector(j.offset), thick = length * (0.034 - 0.02 * (i / Math.max(1, data.joints.length - 1)));
      if (offset.length() > 1e-6) parent.add(rod(nothing, offset, thick, skin));
      const pivot = new three.Group(), half = vector(j.direction).multiplyScalar(thick * 1.5);
      pivot.position.copy(offset);
      pivot.add(rod(half.clone().negate(), half, thick * 1.25, joint));
      parent.add(pivot);
      pivots.push(pivot);
      parent = pivot;
    });
    const flange = new three.Group();
    flange.position.copy(vector(data.flange));
    if (flange.position.length() > 1e-6) parent.add(rod(nothing, flange.position, length * 0.012, skin));
    parent.add(flange);
    const tool = rod(nothing, vector([0, 0, 1]), length * 0.006, joint);
    flange.add(tool);
    /** The pose at `time` [s], between samples linearly; false where it is not known. */
    const pose = (time) => {
      const i = page.before(data.t, time), k = Math.min(i + 1, data.t.length - 1);
      const share = data.t[k] > data.t[i] ? Math.min(1, Math.max(0, (time - data.t[i]) / (data.t[k] - data.t[i]))) : 0;
      const values = data.axes.map((axis) => (axis[i] === null || axis[k] === null ? null : axis[i] + (axis[k] - axis[i]) * share));
      root.visible = values.every((v) => v !== null);
      if (!root.visible) return;
      data.joints.forEach((j, n) => {
        if (data.linear[j.axis]) pivots[n].position.set(...j.offset).addScaledVector(vector(j.direction), values[j.axis]);
        else pivots[n].quaternion.copy(turned(j.direction, values[j.axis]));
      });
      root.updateMatrixWorld(true);
    };
    const reachTo = (point) => {
      const end = flange.worldToLocal(point.clone()), far = end.length();
      tool.visible = far > 1;
      if (!tool.visible) return;
      tool.position.copy(end).multiplyScalar(0.5);
      tool.quaternion.setFromUnitVectors(UP, end.clone().normalize());
      tool.scale.y = far;
    };
    const extend = (extent) => {
      for (let n = 0; n < 40; n++) {
        pose(data.t[Math.floor((n / 40) * data.t.length)]);
        for (const pivot of [...pivots, flange]) if (root.visible) extent.expandByPoint(pivot.getWorldPosition(new three.Vector3()));
      }
    };
    return { root, pose, reachTo, extend };
  };

  const thick = (points, width, more) => {
    const geometry = new three.LineSegmentsGeometry().setPositions(points);
    return new three.LineSegments2(geometry, new three.LineMaterial({ linewidth: width, ...more }));
  };
  const drawn = (wanted) => {
    const { path } = shown.d, points = [];
    for (let i = 1; i < path.x.length; i++) if (wanted(i)) points.push(path.x[i - 1], path.y[i - 1], path.z[i - 1], path.x[i], path.y[i], path.z[i]);
    return points;
  };

  /** The path in the colours of time or speed, and what they mean. */
  const colours = () => {
    const { d } = shown, ramp = page.ramp();
    const value = (step) => (by === "time" ? d.seconds[step] : d.reached[step]) || 0;
    const top = d.seconds.reduce((most, _, s) => Math.max(most, value(s)), 1e-9), tones = [], tone = new three.Color();
    for (let i = 1; i < d.path.x.length; i++) {
      const share = Math.sqrt(Math.min(1, value(d.path.step[i]) / top));
      const half = share < 0.5 ? 0 : 1, part = 2 * share - half;
      tone.setRGB(...ramp[half].map((c, k) => (c + (ramp[half + 1][k] - c) * part) / 255), "srgb");
      tones.push(tone.r, tone.g, tone.b, tone.r, tone.g, tone.b);
    }
    if (line) { line.geometry.dispose(); line.material.dispose(); line.removeFromParent(); }
    line = thick(drawn(() => true), 2.6, { vertexColors: true });
    line.geometry.setColors(tones);
    content.add(line);
    page.$("least").textContent = "0";
    page.$("most").textContent = (top >= 10 ? top.toFixed(0) : top.toFixed(2)) + (by === "time" ? " s" : " mm/s");
    render();
  };

  const choose = (step) => {
    chosen = step;
    if (!renderer || !content) return;
    const points = step < 0 ? [] : drawn((i) => shown.d.path.step[i] === step);
    chosenLine.geometry.dispose();
    chosenLine.geometry = new three.LineSegmentsGeometry().setPositions(points);
    chosenLine.visible = points.length > 0;
    render();
  };

  /** The instant [s]: the tool's point and the arm. */
  const at = (time) => {
    now = time;
    if (!renderer || !content) return;
    marker.visible = Boolean(shown.d.path.t);
    if (!marker.visible) return;
    const { t, x, y, z } = shown.d.path, i = page.before(t, time), k = Math.min(i + 1, t.length - 1);
    const share = t[k] > t[i] ? Math.min(1, Math.max(0, (time - t[i]) / (t[k] - t[i]))) : 0;
    marker.position.set(...[x, y, z].map((v) => v[i] + (v[k] - v[i]) * share));
    if (arm) { arm.pose(time); arm.reachTo(marker.position); }
    render();
  };

  const hands = () => {
    const caster = new three.Raycaster(), surface = renderer.domElement;
    caster.params.Line2 = { threshold: 10 };
    const under = (e) => {
      const area = surface.getBoundingClientRect();
      caster.setFromCamera(new three.Vector2(((e.clientX - area.left) / area.width) * 2 - 1, 1 - ((e.clientY - area.top) / area.height) * 2), camera);
      const [hit] = line ? caster.intersectObject(line, false) : [];
      return hit ? shown.d.path.step[hit.faceIndex + 1] : -1;
    };
    let pressed = null;
    surface.addEventListener("pointerdown", (e) => { pressed = [e.clientX, e.clientY]; page.tip(null); });
    surface.addEventListener("pointerup", (e) => {
      const still = pressed && Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) < 4;
      pressed = null;
      const step = still ? under(e) : -1;
      if (step >= 0) page.pick(step);
    });
    surface.addEventListener("pointermove", (e) => {
      if (pressed || e.pointerType === "touch") return;
      const step = under(e);
      page.tip(e, step < 0 ? [] : page.describe(step));
    });
    surface.addEventListener("pointerleave", () => page.tip(null));
    box.addEventListener("keydown", (e) => {
      const does = {
        ArrowLeft: () => controls.rotateLeft(-0.1), ArrowRight: () => controls.rotateLeft(0.1),
        ArrowUp: () => controls.rotateUp(-0.1), ArrowDown: () => controls.rotateUp(0.1),
        "+": () => controls.dollyIn(1.2), "-": () => controls.dollyOut(1.2), 0: () => fit("whole"),
      }[e.key];
      if (!does) return;
      e.preventDefault();
      does();
      controls.update();
    });
  };

  /** How the picture is turned; with an argument it is turned so. */
  const keep = (turned) => {
    if (!renderer || !content) return null;
    if (turned) { camera.position.copy(turned[0]); controls.target.copy(turned[1]); controls.update(); render(); }
    return [camera.position.clone(), controls.target.clone()];
  };

  return { show, choose, at, fit, keep, resize, paint, colour: (what) => { by = what; if (content) colours(); } };
};
