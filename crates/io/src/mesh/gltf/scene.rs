//! Which nodes are shown, and where.

use super::transform::Transform;
use crate::{Place, ReadFault, mesh::input::MeshFile};
use gltf_json::{Index, Node, Root};

/// A node of the scene and the map from its own space to the world.
pub(super) struct Shown<'a> {
    pub(super) node: &'a Node,
    pub(super) transform: Transform,
}

/// The nodes of the default scene, or of the first; without scenes, all. Parents before children, in the
/// order of the file.
pub(super) fn shown<'a>(file: MeshFile<'_>, root: &'a Root) -> Result<Vec<Shown<'a>>, ReadFault> {
    let mut was_seen = vec![false; root.nodes.len()];
    let mut todo: Vec<(Index<Node>, Transform)> =
        tops(root).into_iter().rev().map(|node| (node, Transform::IDENTITY)).collect();
    let mut shown = vec![];
    while let Some((index, outer)) = todo.pop() {
        let place = Place::Item("node", index.value() as u64);
        let Some(node) = root.get(index) else {
            return Err(file.broken(place, "a node", "a number that none has"));
        };
        // So there are no circles either.
        if std::mem::replace(&mut was_seen[index.value()], true) {
            return Err(file.broken(place, "one parent or none", "two"));
        }
        let transform = outer.after(&Transform::of(node));
        shown.push(Shown { node, transform });
        let children = node.children.iter().flatten().rev();
        todo.extend(children.map(|&child| (child, transform)));
    }
    Ok(shown)
}

fn tops(root: &Root) -> Vec<Index<Node>> {
    let scene = root.scene.and_then(|scene| root.get(scene)).or(root.scenes.first());
    if let Some(scene) = scene {
        return scene.nodes.clone();
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let numbers = (0..root.nodes.len() as u32).zip(is_child);
    let tops = numbers.filter(|(_, is_child)| !is_child).map(|(number, _)| Index::new(number));
    let tops: Vec<_> = tops.collect();
    // Where all have parents, they go round in circles, and the first one shows it.
    let first = (0..root.nodes.len() as u32).map(Index::new).take(1);
    if tops.is_empty() { first.collect() } else { tops }
}
