//! Bodies of a data set with their sound models, kept from strike to strike.
//!
//! Of a large data set, those that were needed last are kept; a table or `repeat` that has the strikes on one
//! body in a row loads each once.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::medium::Medium;
use clangor_core::scene::body_description::Geometry;
use clangor_core::scene::render_description::Parts;
use clangor_core::scene::strike_recipe::StruckObject;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::strike;

use super::error::DatasetError;
use super::strikes::Strikes;
use super::surface_points::SurfacePoints;
use crate::session::sounding_body::SoundingBody;
use crate::session::strike::{t60, usual_impact};
use crate::session::struck_model::ModelChoice;
use crate::session::{Progress, StrikeRemark, StruckBody};
use crate::stages::sound_models::Quality;

/// Most bodies that are kept between groups of strikes: a gigabyte or so.
const MOST_KEPT: usize = 256;

/// A body that is ready to be struck.
#[derive(Clone, Debug)]
pub(super) struct ReadyBody {
    pub(super) struck: StruckBody,
    pub(super) sounding: SoundingBody,
    pub(super) points: SurfacePoints,
    /// Frequencies of its modes \[Hz\].
    pub(super) frequencies: Arc<[f64]>,
    /// Times in which they fall by 60 dB \[s\].
    pub(super) t60s: Arc<[f64]>,
    /// Whether a part of its model is a draft.
    pub(super) is_draft: bool,
}

/// How bodies are made ready.
#[derive(Clone, Debug)]
pub(super) struct BodySettings {
    /// Folder that paths of objects are relative to.
    pub(super) folder: PathBuf,
    pub(super) choice: ModelChoice,
    pub(super) sample_rate: SampleRate,
}

/// A defect of the sound model of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyRemark {
    /// Its object.
    pub object: String,
    /// Its material.
    pub material: String,
    /// What there is to say.
    pub remark: StrikeRemark,
}

impl fmt::Display for BodyRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\" of {}: {}", self.object, self.material, self.remark)
    }
}

/// Bodies by object and material.
#[derive(Debug, Default)]
pub(super) struct StruckBodies {
    kept: BTreeMap<(usize, usize), Kept>,
    /// Bodies with remarks, which are made once.
    remarked: BTreeSet<(usize, usize)>,
    remarks: Vec<BodyRemark>,
    /// Number of the present group of strikes.
    group: u64,
}

#[derive(Debug)]
struct Kept {
    body: Arc<ReadyBody>,
    group: u64,
}

impl StruckBodies {
    /// Forgets bodies that were not needed lately, before a group of strikes.
    pub(super) fn begin_group(&mut self) {
        self.group += 1;
        while self.kept.len() > MOST_KEPT {
            let oldest = self.kept.iter().min_by_key(|(_, kept)| kept.group).map(|(key, _)| *key);
            match oldest {
                Some(key) => self.kept.remove(&key),
                None => return,
            };
        }
    }

    /// A body, read and baked where it is not there yet.
    ///
    /// # Errors
    /// [`DatasetError::Object`].
    pub(super) fn obtain(
        &mut self,
        strikes: &Strikes,
        key: (usize, usize),
        settings: &BodySettings,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Arc<ReadyBody>, DatasetError> {
        let group = self.group;
        if let Some(kept) = self.kept.get_mut(&key) {
            kept.group = group;
            return Ok(Arc::clone(&kept.body));
        }
        let (object, material) = (&strikes.objects[key.0], &strikes.materials[key.1]);
        let body = ready(object, material, settings, on_progress).map_err(|source| DatasetError::Object {
            object: object.name.clone(),
            material: material.name.clone(),
            source: Box::new(source),
        })?;
        self.note(key, (&object.name, &material.name), body.sounding.remarks(), settings);
        let body = Arc::new(body);
        self.kept.insert(key, Kept { body: Arc::clone(&body), group });
        Ok(body)
    }

    /// Keeps the remarks on a body, but that a draft is one where drafts are asked for: labels say so.
    fn note(
        &mut self,
        key: (usize, usize),
        (object, material): (&str, &str),
        remarks: &[StrikeRemark],
        settings: &BodySettings,
    ) {
        let drafts = settings.choice.options.quality == Quality::Draft;
        let is_news = |remark: &&StrikeRemark| !(drafts && matches!(remark, StrikeRemark::Draft { .. }));
        if remarks.iter().any(|remark| is_news(&remark)) && self.remarked.insert(key) {
            self.remarks.extend(remarks.iter().filter(is_news).map(|remark| BodyRemark {
                object: object.into(),
                material: material.into(),
                remark: remark.clone(),
            }));
        }
    }

    /// Adds the remarks on bodies of others.
    pub(super) fn add_remarks(&mut self, others: StruckBodies) {
        self.remarked.extend(others.remarked);
        self.remarks.extend(others.remarks);
    }

    /// The remarks since the last call.
    pub(super) fn take_remarks(&mut self) -> Vec<BodyRemark> {
        std::mem::take(&mut self.remarks)
    }
}

fn ready(
    object: &StruckObject,
    material: &Material,
    settings: &BodySettings,
    on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<ReadyBody, crate::session::Error> {
    let word = word(object, &settings.folder);
    let struck = StruckBody::open(&word, object.scale, Some(material.clone()))?;
    let impact = strike::Strike {
        sample_rate: settings.sample_rate,
        max_frequency: settings.choice.options.max_frequency,
        medium: Medium::AIR,
        ..usual_impact(DVec3::ZERO)
    };
    let sounding = SoundingBody::obtain(&struck, &settings.choice, &Parts::default(), &impact, on_progress)?;
    let modes = sounding.resonances();
    Ok(ReadyBody {
        points: SurfacePoints::new(&struck.body().surface),
        frequencies: modes.iter().map(|mode| mode.frequency).collect(),
        t60s: modes.iter().map(t60).collect(),
        is_draft: sounding.remarks().iter().any(|remark| matches!(remark, StrikeRemark::Draft { .. })),
        struck,
        sounding,
    })
}

/// The word that names an object for [`StruckBody::open`].
fn word(object: &StruckObject, folder: &Path) -> String {
    match &object.geometry {
        Geometry::Shape(shape) => shape.clone(),
        Geometry::File(file) => folder.join(file).to_string_lossy().into_owned(),
    }
}

/// The file of an object, if it has one.
pub(super) fn file(object: &StruckObject, folder: &Path) -> Option<PathBuf> {
    let Geometry::File(file) = &object.geometry else { return None };
    let whole = folder.join(file);
    let without_body = file.rsplit_once('#').map(|(file, _)| folder.join(file));
    Some(without_body.filter(|_| !whole.exists()).unwrap_or(whole))
}
