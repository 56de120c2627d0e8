//! Reads glTF: each primitive of each node that is shown becomes a surface, in z up, with the transforms of
//! its nodes and the factor to metres undone.

use super::{
    Scale,
    accessor::Accessors,
    buffers::buffers,
    container::Container,
    document::VALUE,
    scene::{Shown, shown},
    transform::Transform,
};
use crate::{
    Place, ReadError, ReadFault,
    mesh::{
        NEUTRAL,
        axes::z_up,
        facts::{MAKER, space},
        input::{MeshFile, MeshInput, beyond, fan, is_beyond, textured},
    },
};
use gltf_json::{
    Asset, Material, Mesh, Root, material::AlphaMode, mesh::Mode, mesh::Primitive, mesh::Semantic,
    validation::Checked,
};
use isokit_geom::{Space, Unit};
use isokit_mesh::{Attributes, Positions, Rgba, Surface, TriMesh};
use serde_json::Value;

/// Reads all surfaces of a file and of the buffers that it names.
pub(in crate::mesh) fn read(file: MeshFile<'_>) -> Result<MeshInput, ReadError> {
    let at = |fault: ReadFault| fault.at(file.path);
    let Container { root, bin } = Container::open(file).map_err(at)?;
    refuse(file, &root).map_err(at)?;
    let buffers = buffers(file, &root, bin)?;
    let accessors = Accessors { file, root: &root, buffers: &buffers };
    let world = World::of(&root.asset);
    let (mut found, mut bytes) = (Found::default(), 0);
    for node in shown(file, &root).map_err(at)? {
        let before = found.surfaces.len();
        add(&mut found, &accessors, &world, &node).map_err(at)?;
        // A small file may show a large mesh many times.
        bytes += found.surfaces[before..].iter().map(|surface| size(&surface.mesh)).sum::<u64>();
        file.job.limits.allow("the surfaces", Some(bytes), 1).map_err(|over| at(over.into()))?;
    }
    let World { unit, space, .. } = world;
    let notes = textured(&found.with_texture).into_iter().chain(beyond(found.beyond)).collect();
    let surfaces = found.surfaces;
    Ok(MeshInput { surfaces, format: file.format, unit, space, notes })
}

/// Goes on if no extension is required that would change a shape.
fn refuse(file: MeshFile<'_>, root: &Root) -> Result<(), ReadFault> {
    const HARMLESS: [&str; 5] = [
        "KHR_mesh_quantization", // other component types, which are read anyway
        "KHR_materials_",
        "KHR_texture_",
        "EXT_texture_",
        "KHR_lights_",
    ];
    let is_harmless = |name: &String| HARMLESS.iter().any(|harmless| name.starts_with(harmless));
    match root.extensions_required.iter().find(|name| !is_harmless(name)) {
        Some(name) => Err(file.unsupported(Place::Item("required extension", 0), name.clone())),
        None => Ok(()),
    }
}

/// What `asset.extras` says, if we wrote it.
struct World {
    is_ours: bool,
    scale: Scale,
    unit: Unit,
    space: Space,
}

impl World {
    fn of(asset: &Asset) -> Self {
        let maker = MAKER.split(' ').next().unwrap_or_default();
        let made = asset.generator.as_ref().and_then(|name| name.split(' ').next());
        let extras = asset.extras.as_ref().filter(|_| made == Some(maker));
        let extras: Option<Value> = extras.and_then(|raw| serde_json::from_str(raw.get()).ok());
        let metres = extras.as_ref().and_then(|extras| extras["metres_per_unit"].as_f64());
        match (extras, metres.filter(|metres| metres.is_normal() && *metres > 0.0)) {
            (Some(extras), Some(metres)) => {
                let text = |key: &str| extras[key].as_str().unwrap_or_default();
                let unit = Unit::from_symbol(text("unit")).unwrap_or_default();
                Self { is_ours: true, scale: Scale(metres), unit, space: space(text("space")) }
            }
            _ => {
                Self { is_ours: false, scale: Scale(1.0), unit: Unit::Metre, space: Space::Unknown }
            }
        }
    }
}

/// What was read so far.
#[derive(Default)]
struct Found {
    surfaces: Vec<Surface>,
    /// Names of those with a texture, which says of their colour what nothing else does.
    with_texture: Vec<String>,
    /// How many vertices have a colour with a part that is not from 0 to 1.
    beyond: usize,
}

/// Adds the surfaces of a node.
fn add(
    found: &mut Found,
    accessors: &Accessors<'_>,
    world: &World,
    Shown { node, transform }: &Shown<'_>,
) -> Result<(), ReadFault> {
    let name = node.name.clone();
    let extras = node.extras.as_ref().and_then(|raw| serde_json::from_str(raw.get()).ok());
    let iso = extras.and_then(|extras: Value| extras["iso"].as_f64());
    let Some(index) = node.mesh else {
        // An empty surface of ours; anybody else's is a joint or a group.
        if world.is_ours && node.children.is_none() {
            let name = name.unwrap_or_default();
            found.surfaces.push(Surface { name, iso, ..Surface::default() });
        }
        return Ok(());
    };
    let place = Place::Item("mesh", index.value() as u64);
    let mesh: &Mesh = accessors
        .root
        .get(index)
        .ok_or_else(|| accessors.file.broken(place, "a mesh", "a number that none has"))?;
    let name = name.or_else(|| mesh.name.clone()).unwrap_or_default();
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let name = if number == 0 { name.clone() } else { format!("{name}_{}", number + 1) };
        let material = material(accessors.root, primitive);
        let color = material.map(color);
        let mesh = triangles(accessors, world, transform, primitive, (place, &mut found.beyond))?;
        // Of ours, where it only says that there is none.
        let plain = if mesh.attributes.colors.is_some() { Rgba([u8::MAX; 4]) } else { NEUTRAL };
        let color = color.filter(|&color| !(world.is_ours && color == plain));
        let has_texture = |it: &Material| it.pbr_metallic_roughness.base_color_texture.is_some();
        // Colours of vertices would be multiplied by those of the texture.
        if material.is_some_and(has_texture) {
            found.with_texture.push(name.clone());
        }
        found.surfaces.push(Surface { name, color, iso, mesh });
    }
    Ok(())
}

fn size(mesh: &TriMesh) -> u64 {
    let normals = mesh.normals.as_ref().map_or(0, Vec::len);
    let attributes = if mesh.attributes.is_empty() { 0 } else { mesh.positions.len() };
    12 * (mesh.positions.len() + normals + attributes + mesh.triangles.len()) as u64
}

fn material<'a>(root: &'a Root, primitive: &Primitive) -> Option<&'a Material> {
    root.get(primitive.material?)
}

fn color(material: &Material) -> Rgba {
    Rgba::from_linear(shown_color(
        Some(material),
        material.pbr_metallic_roughness.base_color_factor.0,
    ))
}

/// A colour as its material shows it: where it is not said to blend or to mask, opacity counts for nothing.
fn shown_color(material: Option<&Material>, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
    let has_opacity = material.is_some_and(|material| {
        matches!(material.alpha_mode, Checked::Valid(AlphaMode::Blend | AlphaMode::Mask))
    });
    [r, g, b, if has_opacity { a } else { 1.0 }]
}

fn triangles(
    accessors: &Accessors<'_>,
    world: &World,
    transform: &Transform,
    primitive: &Primitive,
    (place, beyond): (Place, &mut usize),
) -> Result<TriMesh, ReadFault> {
    let file = accessors.file;
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let positions = attribute(Semantic::Positions);
    let positions = positions.ok_or_else(|| file.broken(place, "POSITION", "none"))?;
    let positions = accessors.vectors(positions)?;
    let normals = attribute(Semantic::Normals).map(|index| accessors.vectors(index)).transpose()?;
    let count = positions.len();
    let attributes = attributes(accessors, primitive, (place, beyond), count)?;
    if let Some(found) = normals.as_ref().map(Vec::len).filter(|&found| found != count) {
        return Err(file.broken(place, format!("{count} normals"), found.to_string()));
    }
    let corners = match primitive.indices {
        Some(index) => accessors.indices(index)?,
        // More vertices than `u32` can name are refused here, as no triangle could name them.
        None => (0..count as u64).map_while(|vertex| u32::try_from(vertex).ok()).collect(),
    };
    if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= count) {
        return Err(file.broken(place, format!("vertices below {count}"), corner.to_string()));
    }
    let mut triangles = assembled(file, primitive, &corners, place)?;
    if transform.is_mirror() {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    let narrow = |xyz: [f64; 3]| xyz.map(|c| c as f32);
    let placed = |xyz: &[f64; 3]| narrow(world.scale.restore(transform.point(*xyz)));
    let turned = |xyz: &[f64; 3]| narrow(z_up(transform.normal(*xyz)));
    Ok(TriMesh {
        positions: Positions::F32(positions.iter().map(placed).collect()),
        normals: normals.map(|normals| normals.iter().map(turned).collect()),
        triangles,
        attributes,
    })
}

/// The colours and numbers of vertices. Of a colour, that of the material is a part.
fn attributes(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    (place, beyond): (Place, &mut usize),
    count: usize,
) -> Result<Attributes, ReadFault> {
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let material = material(accessors.root, primitive);
    let base = material.map_or([1.0; 4], |it| it.pbr_metallic_roughness.base_color_factor.0);
    let mut color = |linear: [f64; 4]| {
        *beyond += usize::from(linear.into_iter().any(is_beyond));
        let whole = std::array::from_fn(|k| linear[k] as f32 * base[k]);
        Rgba::from_linear(shown_color(material, whole))
    };
    let colors = match attribute(Semantic::Colors(0)) {
        Some(index) => {
            Some(accessors.colors(index)?.into_iter().map(&mut color).collect::<Vec<_>>())
        }
        None => None,
    };
    let values = attribute(Semantic::Extras(VALUE.to_owned()));
    let values = values.and_then(|index| accessors.scalars(index)).transpose()?;
    let lengths = [colors.as_ref().map(Vec::len), values.as_ref().map(Vec::len)];
    match lengths.into_iter().flatten().find(|&length| length != count) {
        Some(found) => {
            let expected = format!("{count} colours and values of vertices");
            Err(accessors.file.broken(place, expected, found.to_string()))
        }
        None => Ok(Attributes { values, colors }),
    }
}

/// The triangles of a list, a strip or a fan.
fn assembled(
    file: MeshFile<'_>,
    primitive: &Primitive,
    corners: &[u32],
    place: Place,
) -> Result<Vec<[u32; 3]>, ReadFault> {
    match primitive.mode {
        Checked::Valid(Mode::Triangles) => match corners.as_chunks::<3>() {
            (triangles, []) => Ok(triangles.to_vec()),
            _ => {
                let found = format!("{} corners", corners.len());
                Err(file.broken(place, "three corners for each triangle", found))
            }
        },
        // Every second triangle of a strip is wound the other way.
        Checked::Valid(Mode::TriangleStrip) => Ok(corners
            .windows(3)
            .enumerate()
            .map(|(k, corner)| match k % 2 {
                0 => [corner[0], corner[1], corner[2]],
                _ => [corner[1], corner[0], corner[2]],
            })
            .collect()),
        Checked::Valid(Mode::TriangleFan) => Ok(fan(corners).collect()),
        Checked::Valid(mode) => Err(file.unsupported(place, format!("a primitive of {mode:?}"))),
        Checked::Invalid => Err(file.broken(place, "a mode of glTF 2.0", "another")),
    }
}
