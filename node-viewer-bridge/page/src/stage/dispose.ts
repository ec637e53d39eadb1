// Gives back what three.js holds on the graphics card: it frees nothing by itself.

import { type Material, Mesh, type Object3D, type Texture } from "three";

/** Empties `parent` and frees the geometries, materials and textures below it. */
export function dispose(parent: Object3D): void {
  parent.traverse((node) => {
    const drawn = node as Partial<Pick<Mesh, "geometry" | "material">>;
    drawn.geometry?.dispose();
    const materials = drawn.material ?? [];
    for (const material of Array.isArray(materials) ? materials : [materials]) disposeMaterial(material);
  });
  parent.clear();
}

function disposeMaterial(material: Material & { map?: Texture | null }): void {
  material.map?.dispose();
  material.dispose();
}
