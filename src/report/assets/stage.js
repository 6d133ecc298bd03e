"use strict";
// What is drawn in a view: camera and lights, lines as tubes, arrows, tracks, axes. Knows nothing of time.
globalThis.Stage = class Stage {
  // `size`: length of the structure, which everything else is scaled by.
  constructor(box, size, style) {
    this.style = style;
    this.size = size;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    box.append(this.renderer.domElement);
    this.box = box;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(35, 1, size / 500, 500 * size);
    this.camera.up.set(0, 0, 1);
    const sun = new THREE.DirectionalLight(0xffffff, 2.2);
    sun.position.set(0.4, 0.8, 1);
    this.camera.add(sun);
    this.scene.add(this.camera, new THREE.AmbientLight(0xffffff, 1.3));
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.render());
    this.axes = { G: this.triad(0.22 * size), A: this.triad(0.12 * size) };
    this.grid = null;
    this.resize();
  }

  resize() {
    const width = Math.max(1, this.box.clientWidth);
    const height = Math.round(Math.min(560, Math.max(260, 0.56 * width)));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  render() {
    this.renderer.setClearColor(new THREE.Color(this.style("--page")));
    this.renderer.render(this.scene, this.camera);
  }

  // Looks at a box from a corner of it.
  look({ least, most }) {
    const [a, b] = [new THREE.Vector3(...least), new THREE.Vector3(...most)];
    const centre = a.clone().add(b).multiplyScalar(0.5);
    const from = new THREE.Vector3(-0.55, -0.75, 0.42).normalize();
    const right = this.camera.up.clone().cross(from).normalize();
    const up = from.clone().cross(right);
    // So far away that every corner is inside the picture, with room for arrows.
    const tangent = Math.tan((this.camera.fov * Math.PI) / 360);
    let distance = 0.6 * this.size;
    for (let corner = 0; corner < 8; corner++) {
      const x = new THREE.Vector3(...[0, 1, 2].map((k) => (corner & (1 << k) ? most[k] : least[k]))).sub(centre);
      const [across, above] = [Math.abs(x.dot(right)) / this.camera.aspect, Math.abs(x.dot(up))];
      distance = Math.max(distance, (1.15 * Math.max(across, above)) / tangent + x.dot(from));
    }
    this.camera.near = distance / 200;
    this.camera.far = 50 * distance;
    this.camera.position.copy(centre).add(from.multiplyScalar(distance));
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.update();
  }

  // A net on the ground below a box, with cells of 1, 2 or 5 times a power of ten; the length of one is returned.
  ground({ least, most }) {
    if (this.grid) this.drop(this.grid);
    const span = 1.4 * Math.max(most[0] - least[0], most[1] - least[1], this.size);
    const power = 10 ** Math.floor(Math.log10(span / 8));
    const cell = [1, 2, 5, 10].map((k) => k * power).find((c) => span / c <= 16);
    const cells = 2 * Math.ceil(span / cell / 2);
    const middle = [0, 1].map((k) => cell * Math.round((least[k] + most[k]) / 2 / cell));
    this.grid = new THREE.GridHelper(cell * cells, cells, this.style("--line"), this.style("--grid"));
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(...middle, least[2] - 0.06 * this.size);
    this.scene.add(this.grid);
    return cell;
  }

  drop(object) {
    this.scene.remove(object);
    object.traverse((part) => {
      part.geometry?.dispose();
      part.material?.dispose();
    });
  }

  triad(length) {
    const geometry = new THREE.BufferGeometry();
    const ends = new Float32Array(18);
    [0, 1, 2].forEach((k) => (ends[6 * k + 3 + k] = length));
    geometry.setAttribute("position", new THREE.BufferAttribute(ends, 3));
    const colours = ["#d33", "#2a2", "#36f"].flatMap((name) => {
      const { r, g, b } = new THREE.Color(name);
      return [r, g, b, r, g, b];
    });
    geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(colours), 3));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ vertexColors: true }));
    this.scene.add(lines);
    return lines;
  }

  // Tubes between pairs of nodes, to be placed by `set`.
  tubes(segments, colour, thickness, opacity = 1) {
    const material = new THREE.MeshLambertMaterial({ color: colour, transparent: opacity < 1, opacity });
    const count = segments.length / 2;
    const sides = count > 3000 ? 5 : 10;
    const mesh = new THREE.InstancedMesh(new THREE.CylinderGeometry(1, 1, 1, sides, 1), material, count);
    mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    const radius = thickness * this.size;
    const [along, side, up] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    const set = (nodes) => {
      const into = mesh.instanceMatrix.array;
      for (let s = 0; s < count; s++) {
        const [a, b] = [3 * segments[2 * s], 3 * segments[2 * s + 1]];
        along.set(nodes[b] - nodes[a], nodes[b + 1] - nodes[a + 1], nodes[b + 2] - nodes[a + 2]);
        // Any direction across: away from the axis of G that the tube is least along.
        const flat = Math.abs(along.z) < Math.max(Math.abs(along.x), Math.abs(along.y));
        side.set(flat ? 0 : 1, 0, flat ? 1 : 0).cross(along).normalize().multiplyScalar(radius);
        up.copy(side).cross(along).normalize().multiplyScalar(radius);
        into.set([side.x, side.y, side.z, 0, along.x, along.y, along.z, 0, up.x, up.y, up.z, 0], 16 * s);
        into.set([0, 1, 2].map((k) => (nodes[a + k] + nodes[b + k]) / 2).concat(1), 16 * s + 12);
      }
      mesh.instanceMatrix.needsUpdate = true;
    };
    return { mesh, set };
  }

  ball(colour, radius) {
    const material = new THREE.MeshLambertMaterial({ color: colour });
    const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius * this.size, 16, 12), material);
    this.scene.add(mesh);
    return mesh;
  }

  // A line through points that are added one after the other: all there are at once, of which the first `n` show.
  track(colour) {
    const material = new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity: 0.75 });
    const line = new THREE.Line(new THREE.BufferGeometry(), material);
    line.frustumCulled = false;
    this.scene.add(line);
    return line;
  }

  // An arrow of unit length along z; a moment has two heads.
  arrow(colour, isMoment) {
    const material = new THREE.MeshLambertMaterial({ color: colour });
    const radius = 0.011 * this.size;
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.35 * radius, 0.35 * radius, 1, 10), material);
    const heads = (isMoment ? [0, 1] : [0]).map(() => new THREE.Mesh(new THREE.ConeGeometry(radius, 3 * radius, 14), material));
    const group = new THREE.Group();
    [shaft, ...heads].forEach((part) => part.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, 0, 1)));
    group.add(shaft, ...heads);
    this.scene.add(group);
    const [direction, from] = [new THREE.Vector3(), new THREE.Vector3(0, 0, 1)];
    const set = (at, vector, length) => {
      direction.set(...vector).normalize();
      group.visible = length > 1e-3 * this.size;
      group.position.set(...at);
      group.quaternion.setFromUnitVectors(from, direction);
      shaft.scale.y = Math.max(1e-6, length - 2 * radius);
      shaft.position.z = 0.5 * shaft.scale.y;
      heads.forEach((head, i) => (head.position.z = length - (1.5 + 2 * i) * radius));
    };
    return { group, set };
  }
};
