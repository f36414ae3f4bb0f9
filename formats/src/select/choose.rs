//! What a selection means for the fields, antennas and channels of an observation; errors in words.

use std::collections::BTreeSet;

use super::Selection;
use crate::{FreqSetup, Observation, VisChunk};

/// Pairs of antennas, the smaller index first, and antennas of which all pairs are wanted.
type Baselines = (BTreeSet<(u32, u32)>, BTreeSet<u32>);

/// Which rows are wanted.
#[derive(Debug)]
pub(super) struct Rows {
    /// The only field wanted.
    field: Option<u32>,
    times_mjd: Option<[f64; 2]>,
    baselines: Option<Baselines>,
    cross_only: bool,
}

impl Rows {
    /// Leaves the field wanted in the observation.
    pub(super) fn choose(
        observation: &mut Observation,
        selection: &Selection,
    ) -> Result<Self, String> {
        let field = match &selection.field {
            Some(wanted) => Some(field(observation, wanted)?),
            None => None,
        };
        let baselines = match selection.baselines.as_slice() {
            [] => None,
            list => Some(baselines(observation, list)?),
        };
        if let Some([first, last]) = selection.times_mjd.filter(|[first, last]| first > last) {
            return Err(format!(
                "the times end (MJD {last}) before they begin (MJD {first})"
            ));
        }
        if let Some(field) = field {
            observation.fields = vec![observation.fields[field as usize].clone()];
        }
        Ok(Self {
            field,
            times_mjd: selection.times_mjd,
            baselines,
            cross_only: selection.cross_only,
        })
    }

    /// Whether a row is wanted.
    pub(super) fn has(&self, chunk: &VisChunk, row: usize) -> bool {
        let (a, b) = (chunk.ant1_r[row], chunk.ant2_r[row]);
        let time_mjd = chunk.time_mjd_r[row];
        self.field.is_none_or(|field| chunk.field_r[row] == field)
            && (self.times_mjd).is_none_or(|[first, last]| (first..=last).contains(&time_mjd))
            && !(self.cross_only && a == b)
            && self.baselines.as_ref().is_none_or(|(pairs, antennas)| {
                pairs.contains(&(a.min(b), a.max(b)))
                    || antennas.contains(&a)
                    || antennas.contains(&b)
            })
    }

    /// The new index of a field.
    pub(super) fn field(&self, field: u32) -> u32 {
        if self.field.is_some() { 0 } else { field }
    }
}

/// The index of a field by its name, or else by its number.
fn field(observation: &Observation, wanted: &str) -> Result<u32, String> {
    let fields = &observation.fields;
    let by_name = fields.iter().position(|f| f.name.trim() == wanted.trim());
    let by_number = || wanted.parse().ok().filter(|i| *i < fields.len());
    by_name.or_else(by_number).map(|i| i as u32).ok_or_else(|| {
        let list = fields.iter().enumerate();
        let list: Vec<_> = list.map(|(i, f)| format!("{i} {}", f.name)).collect();
        format!(
            "there is no field '{wanted}'; there are: {}",
            list.join(", ")
        )
    })
}

fn baselines(
    observation: &Observation,
    list: &[(String, Option<String>)],
) -> Result<Baselines, String> {
    let (mut pairs, mut antennas) = (BTreeSet::new(), BTreeSet::new());
    for (first, second) in list {
        let a = antenna(observation, first)?;
        match second {
            Some(second) => {
                let b = antenna(observation, second)?;
                pairs.insert((a.min(b), a.max(b)));
            }
            None => {
                antennas.insert(a);
            }
        }
    }
    Ok((pairs, antennas))
}

/// The index of an antenna by its name, or else by its number in the file.
fn antenna(observation: &Observation, wanted: &str) -> Result<u32, String> {
    const SHOWN: usize = 8;
    let antennas = &observation.antennas;
    let by_name = antennas.iter().position(|a| a.name.trim() == wanted.trim());
    let by_number = || {
        let number = wanted.trim().parse().ok()?;
        antennas.iter().position(|a| a.number == number)
    };
    by_name.or_else(by_number).map(|i| i as u32).ok_or_else(|| {
        let names: Vec<_> = antennas.iter().take(SHOWN).map(|a| a.name.trim()).collect();
        let more = if antennas.len() > SHOWN { " ..." } else { "" };
        let list = names.join(", ");
        format!(
            "there is no antenna '{wanted}'; there are {}: {list}{more}",
            antennas.len()
        )
    })
}

/// What stays of a frequency set-up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Cut {
    /// New index of the set-up.
    pub(super) setup: u32,
    /// Channels that stay.
    pub(super) chans: Vec<usize>,
}

/// What stays of each set-up; leaves only that in the observation.
pub(super) fn cuts(
    observation: &mut Observation,
    selection: &Selection,
) -> Result<Vec<Option<Cut>>, String> {
    let windows = observation.windows();
    let is_there = |spw: &&i64| windows.iter().any(|window| window.number == **spw);
    if let Some(missing) = selection.spws.iter().find(|spw| !is_there(spw)) {
        let numbers: Vec<_> = windows.iter().map(|w| w.number.to_string()).collect();
        let list = numbers.join(", ");
        return Err(format!(
            "there is no spectral window {missing}; there are: {list}"
        ));
    }
    // Number of windows and channels of each set-up.
    let mut kept = vec![(Vec::new(), Vec::new()); observation.freq_setups.len()];
    let is_wanted = |number| selection.spws.is_empty() || selection.spws.contains(&number);
    for window in windows.iter().filter(|window| is_wanted(window.number)) {
        let n_chan = window.chans.len();
        let [first, last] = selection.channels.unwrap_or([0, n_chan.saturating_sub(1)]);
        if first > last || last >= n_chan {
            let number = window.number;
            return Err(format!(
                "channels {first} to {last} are not in spectral window {number}, which has {n_chan}, \
                 from 0"
            ));
        }
        let (lens, chans) = &mut kept[window.setup];
        lens.push(last - first + 1);
        chans.extend((window.chans.start + first)..=(window.chans.start + last));
    }
    Ok(apply(observation, kept))
}

fn apply(observation: &mut Observation, kept: Vec<(Vec<usize>, Vec<usize>)>) -> Vec<Option<Cut>> {
    let mut setups = Vec::new();
    let mut cuts = Vec::new();
    for (old, (lens, chans)) in observation.freq_setups.iter().zip(kept) {
        if chans.is_empty() {
            cuts.push(None);
            continue;
        }
        let pick = |values: &[f64]| chans.iter().map(|&f| values[f]).collect();
        let are_even = lens.iter().all(|len| *len == lens[0]);
        let setup = setups.len() as u32;
        setups.push(FreqSetup {
            freq_hz_f: pick(&old.freq_hz_f),
            chan_width_hz_f: pick(&old.chan_width_hz_f),
            n_if: if are_even { lens.len() } else { 1 },
        });
        cuts.push(Some(Cut { setup, chans }));
    }
    if let (Some(notes), [Some(cut)]) = (&mut observation.uvh5, cuts.as_slice()) {
        notes.spw_f = cut
            .chans
            .iter()
            .filter_map(|&f| notes.spw_f.get(f).copied())
            .collect();
    }
    if let Some(ms) = &mut observation.ms {
        let mut cut = cuts.iter();
        ms.spw_s.retain(|_| cut.next().is_some_and(Option::is_some));
    }
    observation.freq_setups = setups;
    cuts
}
