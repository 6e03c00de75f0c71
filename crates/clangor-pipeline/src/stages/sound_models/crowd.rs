//! Who rings by modes of its own in a crowd of many forms: the loudest.
//!
//! Bodies are ranked by the energy J²/2m that impacts give them. The first [`MOST_OWN`] forms have modes of
//! their own. The rest rings as ellipsoids, if there is a bank of its material without a bake, which takes
//! minutes; what is left is silent, and says so.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_bake::modal::ModalBakeOptions;
use clangor_core::body::BodyId;

use super::modal_bake::vibrates_alike;
use super::piece_proxies::Candidate;
use crate::formats::modal_soundbank::is_at_hand;
use crate::formats::model_cache::ModelCache;

/// Forms and materials of a crowd that have modes of their own: drafts of all take a minute.
const MOST_OWN: usize = 32;

/// A crowd, divided.
#[derive(Debug, Default)]
pub(super) struct Divided {
    /// With modes of their own: the bodies of each form and material.
    pub(super) loudest: Vec<Vec<Candidate>>,
    /// With those of ellipsoids.
    pub(super) others: Vec<Candidate>,
    /// With none.
    pub(super) silent: Vec<BodyId>,
}

/// Divides a crowd by the energies of its bodies \[J\]; 0 where none is given.
pub(super) fn divide(
    mut crowd: Vec<Candidate>,
    energies: &BTreeMap<BodyId, f64>,
    (options, cache): (&ModalBakeOptions, Option<&ModelCache>),
) -> Divided {
    let energy = |candidate: &Candidate| energies.get(&candidate.id).copied().unwrap_or(0.0);
    crowd.sort_by(|a, b| energy(b).total_cmp(&energy(a)).then(a.id.cmp(&b.id)));
    let mut divided = Divided::default();
    for candidate in crowd {
        let same = |other: &Candidate| {
            Arc::ptr_eq(&other.body.surface, &candidate.body.surface)
                && vibrates_alike(&other.body, &candidate.body)
        };
        match divided.loudest.iter().position(|form| same(&form[0])) {
            Some(at) => divided.loudest[at].push(candidate),
            None if divided.loudest.len() < MOST_OWN => divided.loudest.push(vec![candidate]),
            None if is_at_hand(&candidate.body.material, options.medium, cache) => {
                divided.others.push(candidate);
            }
            None => divided.silent.push(candidate.id),
        }
    }
    divided
}
