/** A visitor's mesh: read by the module `meshes`, and packed for links. */

import type { MeshPlace } from "../state";
import type { MeshFile } from "./field-messages";
import type { MeshInfo } from "./file-messages";
import { meshOf } from "./scene-files";
import { type Body, ownBody } from "./shapes";

const MOST_MIB = 64;
const MOST_TRIANGLES = 200_000;
/** Least and greatest length that is shown, in m. */
const LENGTHS_M = [0.001, 30] as const;
/** Most bytes of a mesh in a link, so that programs pass it on whole. */
const MOST_PACKED = 12_000;

interface OwnMesh extends MeshInfo {
  /** The closed mesh as OBJ. */
  file: MeshFile;
  /** Of the file. */
  packed: string;
}

/** The snow would not be closed, but may be after a repair. */
export class OpenMesh extends Error {}

export class OwnMeshes {
  private mesh: OwnMesh | undefined;
  private before: OwnMesh | undefined;
  private made: { scale: number; body: Body } | undefined;

  /** The snow of the present mesh; none if it is another or not there yet. */
  body({ name, scale, packed }: MeshPlace): Body | undefined {
    if (this.mesh?.file.name !== name || this.mesh.packed !== packed) return undefined;
    if (this.made?.scale !== scale) this.made = { scale, body: ownBody(this.mesh, scale) };
    return this.made.body;
  }

  get notes(): readonly string[] {
    const { open_edges, notes } = this.mesh ?? { open_edges: 0, notes: [] };
    return open_edges === 0 ? notes : [...notes, `${open_edges} edges of holes were closed`];
  }

  /** Reads a file, whose lengths are multiples of a scale in m. Throws an error of one sentence for a bad file. */
  async take(file: File, scale: number, isRepaired: boolean): Promise<MeshPlace> {
    if (file.size > MOST_MIB * 2 ** 20) throw new Error(`${file.name} is larger than ${MOST_MIB} MiB.`);
    const name = file.name.replace(/[^\w.-]/g, "_");
    const bytes = new Uint8Array(await file.arrayBuffer());
    const mesh = await read({ name, bytes });
    if (mesh.open_edges > 0 && !isRepaired) {
      throw new OpenMesh(`The mesh ${name} has ${mesh.open_edges} open edges, but snow must be a closed solid.`);
    }
    const length = Math.max(...mesh.lengths);
    const [least, greatest] = LENGTHS_M;
    if (!(scale * length >= least && scale * length <= greatest)) {
      throw new Error(`${name} is ${Number((scale * length).toPrecision(3))} m long by the unit of mesh files, but ` +
        `must measure ${1000 * least} mm to ${greatest} m. Choose another unit, and the file again.`);
    }
    const packed = await pack(mesh.file.bytes);
    this.use({ ...mesh, packed });
    return { name: mesh.file.name, scale, length, packed };
  }

  /** Reads the mesh of a link. */
  async unpack({ name, packed }: MeshPlace): Promise<void> {
    const bytes = await unpack(packed).catch(() => {
      throw new Error(`The mesh ${name} of the link is broken.`);
    });
    this.use({ ...(await read({ name, bytes })), packed });
  }

  /** Goes back to the mesh before. */
  revert(): void {
    this.use(this.before);
  }

  height_m({ scale }: MeshPlace): number {
    return scale * (this.mesh?.lengths[2] ?? 0);
  }

  private use(mesh: OwnMesh | undefined): void {
    [this.before, this.mesh, this.made] = [this.mesh, mesh, undefined];
  }
}

async function read(file: MeshFile): Promise<Omit<OwnMesh, "packed">> {
  const { about, obj } = await meshOf(file).catch((error: Error) => {
    throw new Error(`The mesh ${file.name} was refused: ${error.message.replace(`${file.name}: `, "")}.`);
  });
  if (about.triangles > MOST_TRIANGLES) {
    throw new Error(`${file.name} has ${about.triangles} triangles, but may have ${MOST_TRIANGLES}.`);
  }
  return { ...about, file: { name: file.name.replace(/\.\w+$/, ".obj"), bytes: obj } };
}

/** Bytes as a text for links; none if they are too many. */
async function pack(bytes: Uint8Array<ArrayBuffer>): Promise<string> {
  const small = await through(bytes, new CompressionStream("deflate-raw"));
  if (small.length > MOST_PACKED) return "";
  return btoa(String.fromCharCode(...small)).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

async function unpack(text: string): Promise<Uint8Array<ArrayBuffer>> {
  const small = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  return through(Uint8Array.from(small, (one) => one.charCodeAt(0)), new DecompressionStream("deflate-raw"));
}

async function through(bytes: Uint8Array<ArrayBuffer>, stream: GenericTransformStream) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}
