//! One name for each node: programs give instances of a collection the names of their objects, so that
//! several nodes of a file may have one name.

use std::collections::{BTreeMap, BTreeSet};

/// Longest name with those of nodes above it \[bytes\]: a chain of nodes of one name is no reason for names
/// as long as the chain.
const LONGEST: usize = 200;

/// Names that differ, from the own ones. The only solid node of a name keeps it, and the only node where
/// none is solid. Others have the name of their parent before their own, `Instance.001/Coin`, and a number
/// where that is used too: `Coin (2)`. Every node comes after its parent.
pub(super) fn unique_names(own: &[String], parents: &[Option<usize>], is_solid: &[bool]) -> Vec<String> {
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (name, is_solid) in own.iter().zip(is_solid) {
        let [all, solid] = counts.entry(name).or_default();
        *all += 1;
        *solid += usize::from(*is_solid);
    }
    let keeps = |place: usize| match counts.get(own[place].as_str()) {
        Some([all, 0]) => *all == 1,
        Some([_, solid]) => *solid == 1 && is_solid[place],
        None => true,
    };
    let mut taken: BTreeSet<String> =
        (0..own.len()).filter(|place| keeps(*place)).map(|place| own[place].clone()).collect();
    let mut last_number: BTreeMap<String, usize> = BTreeMap::new();
    let mut names: Vec<String> = Vec::with_capacity(own.len());
    for (place, name) in own.iter().enumerate() {
        if keeps(place) {
            names.push(name.clone());
            continue;
        }
        let path = parents[place].map(|parent| format!("{}/{name}", names[parent]));
        let base = path.filter(|path| path.len() <= LONGEST).unwrap_or_else(|| name.clone());
        let mut unique = base.clone();
        let number = last_number.entry(base.clone()).or_insert(1);
        while taken.contains(&unique) {
            *number += 1;
            unique = format!("{base} ({number})");
        }
        taken.insert(unique.clone());
        names.push(unique);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(nodes: &[(&str, Option<usize>, bool)]) -> Vec<String> {
        let own: Vec<String> = nodes.iter().map(|(name, ..)| (*name).to_string()).collect();
        let parents: Vec<Option<usize>> = nodes.iter().map(|(_, parent, _)| *parent).collect();
        let is_solid: Vec<bool> = nodes.iter().map(|(.., is_solid)| *is_solid).collect();
        unique_names(&own, &parents, &is_solid)
    }

    #[test]
    fn names_differ_by_their_parents_and_else_by_a_number() {
        let nodes = [
            ("A", None, false),
            ("Coin", Some(0), true),
            ("B", None, false),
            ("Coin", Some(2), true),
            ("Coin", Some(2), true),
            ("Cube", None, true),
        ];
        assert_eq!(named(&nodes), ["A", "A/Coin", "B", "B/Coin", "B/Coin (2)", "Cube"]);
    }

    #[test]
    fn the_only_solid_node_keeps_its_name() {
        let nodes = [("Coin", None, false), ("Coin", Some(0), true), ("Coin (2)", None, true)];
        assert_eq!(named(&nodes), ["Coin (3)", "Coin", "Coin (2)"]);
        assert_eq!(named(&[("Lamp", None, false), ("Lamp", None, false)]), ["Lamp", "Lamp (2)"]);
    }

    #[test]
    fn names_of_deep_chains_stay_short() {
        let nodes: Vec<(&str, Option<usize>, bool)> =
            (0..1000).map(|place: usize| ("Coin", place.checked_sub(1), true)).collect();
        let names = named(&nodes);
        assert!(names.iter().all(|name| name.len() < 2 * LONGEST));
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
    }
}
