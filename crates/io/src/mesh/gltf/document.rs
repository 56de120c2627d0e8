//! The JSON of a glTF file: a node, a mesh and a material for each surface, all by its name.

use super::{
    Scale,
    content::Bounds,
    layout::{Block, Blocks},
};
use crate::mesh::{MeshContext, NEUTRAL, SurfaceHead, axes::Y_UP, facts::MAKER};
use gltf_json::{
    Accessor, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene,
    accessor::{ComponentType, GenericComponentType, Type},
    buffer::{Target, View},
    extras::RawValue,
    material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor},
    mesh::{Mode, Primitive, Semantic},
    validation::Checked::Valid,
};
use isokit_mesh::Rgba;
use serde_json::{Value, json};

/// What stands in the buffer for a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Content {
    pub(super) blocks: Blocks,
    pub(super) bounds: Bounds,
    /// Whether a vertex lets through what is behind it.
    pub(super) is_translucent: bool,
}

/// What the numbers of vertices are called; a name of one's own begins with `_` in the file.
pub(super) const VALUE: &str = "VALUE";

/// Neither a mirror nor chalk.
const ROUGHNESS: f32 = 0.7;

/// The document of some surfaces; an empty one has no content and becomes a node without a mesh.
pub(super) fn document(
    surfaces: &[(&SurfaceHead, Option<Content>)],
    context: &MeshContext,
    buffer: (u64, Option<String>),
) -> Root {
    let mut root = Root { asset: asset(context), ..Root::default() };
    let (bytes, uri) = buffer;
    if bytes > 0 {
        let byte_length = bytes.into();
        root.push(Buffer { byte_length, uri, name: None, extensions: None, extras: None });
    }
    let nodes = surfaces.iter().map(|(surface, content)| {
        let mesh = content.map(|content| mesh(&mut root, surface, content));
        let extras = surface.iso.filter(|iso| iso.is_finite()).map(|iso| json!({ "iso": iso }));
        let name = named(surface);
        root.push(Node { name, mesh, extras: extras.and_then(raw), ..Node::default() })
    });
    let nodes: Vec<_> = nodes.collect();
    // A scene of nothing is lawful, but `gltf-json` does not read it.
    if !nodes.is_empty() {
        let scene = Scene { nodes, name: None, extensions: None, extras: None };
        root.scene = Some(root.push(scene));
    }
    root
}

fn named(surface: &SurfaceHead) -> Option<String> {
    Some(surface.name.clone()).filter(|name| !name.is_empty())
}

fn raw(value: Value) -> Option<Box<RawValue>> {
    RawValue::from_string(value.to_string()).ok()
}

fn asset(context: &MeshContext) -> Asset {
    let mut extras = json!({
        "axes": Y_UP,
        "metres_per_unit": Scale::of(context).0,
        "space": context.space.to_string(),
        "unit": context.unit.to_string(),
    });
    if !context.command.is_empty() {
        extras["command"] = context.command.clone().into();
    }
    Asset { generator: Some(MAKER.to_owned()), extras: raw(extras), ..Asset::default() }
}

fn mesh(root: &mut Root, surface: &SurfaceHead, content: Content) -> Index<Mesh> {
    let Content { blocks, bounds, is_translucent } = content;
    let vectors = |root: &mut Root, block: Block| {
        let view = view(root, block, Target::ArrayBuffer);
        Accessor {
            type_: Valid(Type::Vec3),
            ..accessor(view, block.bytes / 12, ComponentType::F32)
        }
    };
    let [min, max] = [bounds.min, bounds.max].map(|bound| Some(json!(bound)));
    let positions = Accessor { min, max, ..vectors(root, blocks.positions) };
    let mut attributes = vec![(Semantic::Positions, root.push(positions))];
    if let Some(block) = blocks.normals {
        let normals = vectors(root, block);
        attributes.push((Semantic::Normals, root.push(normals)));
    }
    if let Some(block) = blocks.colors {
        let view = view(root, block, Target::ArrayBuffer);
        let colors = accessor(view, block.bytes / 8, ComponentType::U16);
        let colors = Accessor { type_: Valid(Type::Vec4), normalized: true, ..colors };
        attributes.push((Semantic::Colors(0), root.push(colors)));
    }
    if let Some(block) = blocks.values {
        let view = view(root, block, Target::ArrayBuffer);
        let values = accessor(view, block.bytes / 4, ComponentType::F32);
        attributes.push((Semantic::Extras(VALUE.to_owned()), root.push(values)));
    }
    let view = view(root, blocks.indices, Target::ElementArrayBuffer);
    let indices = root.push(accessor(view, blocks.indices.bytes / 4, ComponentType::U32));
    // Colours of vertices are multiplied by that of the material.
    let color = match blocks.colors {
        Some(_) => Rgba([u8::MAX; 4]),
        None => surface.color.unwrap_or(NEUTRAL),
    };
    let is_translucent = is_translucent || color.is_translucent();
    let material = root.push(material(surface, color, is_translucent));
    let primitive = Primitive {
        attributes: attributes.into_iter().map(|(name, index)| (Valid(name), index)).collect(),
        indices: Some(indices),
        material: Some(material),
        mode: Valid(Mode::Triangles),
        targets: None,
        extensions: None,
        extras: None,
    };
    let (name, primitives) = (named(surface), vec![primitive]);
    root.push(Mesh { name, primitives, weights: None, extensions: None, extras: None })
}

fn view(root: &mut Root, block: Block, target: Target) -> Index<View> {
    root.push(View {
        buffer: Index::new(0),
        byte_offset: Some(block.start.into()),
        byte_length: block.bytes.into(),
        byte_stride: None,
        target: Some(Valid(target)),
        name: None,
        extensions: None,
        extras: None,
    })
}

fn accessor(view: Index<View>, count: u64, component: ComponentType) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: count.into(),
        component_type: Valid(GenericComponentType(component)),
        type_: Valid(Type::Scalar),
        min: None,
        max: None,
        normalized: false,
        sparse: None,
        name: None,
        extensions: None,
        extras: None,
    }
}

/// Opaque surfaces are drawn from both sides: one that is open would else have holes where one looks at
/// its inside, and of a closed one nobody sees the inside. Translucent ones are not, for what lies behind
/// would be blended in no order.
fn material(surface: &SurfaceHead, color: Rgba, is_translucent: bool) -> Material {
    Material {
        name: named(surface),
        alpha_mode: Valid(if is_translucent { AlphaMode::Blend } else { AlphaMode::Opaque }),
        double_sided: !is_translucent,
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(color.to_linear()),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(ROUGHNESS),
            ..PbrMetallicRoughness::default()
        },
        ..Material::default()
    }
}
