//! Mattes of objects and materials for compositing, in the layout of Cryptomatte: the identifiers of the names that a
//! pixel shows, ranked by their coverage (Friedman & Jones 2015, "Fully automatic ID mattes with support for motion
//! blur and transparency", SIGGRAPH 2015 posters; Psyop, "Cryptomatte specification", version 1.2.0).
//!
//! Samples are counted exactly, so that parts of an image can be added in any order. A pixel below its noise target
//! has the coverage of the samples that were traced.

use std::collections::BTreeMap;

/// What has mattes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Matte {
    Object,
    Material,
}

/// Samples of a pixel by what has mattes.
pub(crate) type PixelMattes = [IdCounts; Matte::ALL.len()];

/// The identifier of samples without a surface, which no name has.
pub(crate) const NO_SURFACE: u32 = 0;

impl Matte {
    pub(crate) const ALL: [Self; 2] = [Self::Object, Self::Material];

    /// The name of its layers without their number.
    pub(crate) fn layer(self) -> &'static str {
        match self {
            Self::Object => "CryptoObject",
            Self::Material => "CryptoMaterial",
        }
    }

    /// Names and texts of the attributes that say which names have mattes.
    pub(crate) fn attributes<'names>(self, names: impl Iterator<Item = &'names str>) -> [(String, String); 4] {
        let hexadecimal = |name: &str| format!("{:08x}", id(name));
        let manifest: BTreeMap<&str, String> = names.map(|name| (name, hexadecimal(name))).collect();
        let key = &hexadecimal(self.layer())[..7];
        [
            ("name", self.layer().to_owned()),
            ("hash", "MurmurHash3_32".to_owned()),
            ("conversion", "uint32_to_float32".to_owned()),
            ("manifest", serde_json::json!(manifest).to_string()),
        ]
        .map(|(name, text)| (format!("{ATTRIBUTES}{key}/{name}"), text))
    }
}

/// The beginning of the names of these attributes.
pub(crate) const ATTRIBUTES: &str = "cryptomatte/";

/// The identifier of a name: the bits of a normal 32-bit float.
pub(crate) fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    let exponent = hash >> 23 & 0xff;
    if exponent == 0 || exponent == 0xff { hash ^ 1 << 23 } else { hash }
}

/// The hash MurmurHash3_x86_32 with the seed 0 (Appleby 2011, github.com/aappleby/smhasher).
#[expect(clippy::cast_possible_truncation, reason = "names are shorter than 4 GiB")]
fn murmur3(bytes: &[u8]) -> u32 {
    let mixed =
        |block: [u8; 4]| u32::from_le_bytes(block).wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, rest) = bytes.as_chunks();
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    let add =
        |hash: u32, block: &[u8; 4]| (hash ^ mixed(*block)).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    let hash = blocks.iter().fold(0, add) ^ mixed(last) ^ bytes.len() as u32;
    let hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    let hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

/// Identifiers, each with its number of samples, in the order of the identifiers.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct IdCounts(Vec<[u32; 2]>);

impl IdCounts {
    /// Adds samples.
    pub(crate) fn add(&mut self, id: u32, count: u32) {
        match self.0.binary_search_by_key(&id, |entry| entry[0]) {
            Ok(place) => self.0[place][1] += count,
            Err(place) => self.0.insert(place, [id, count]),
        }
    }

    /// Adds the samples of other counts.
    pub(crate) fn add_all(&mut self, other: &Self) {
        other.0.iter().for_each(|&[id, count]| self.add(id, count));
    }

    /// The entries, as a file stores them.
    pub(crate) fn entries(&self) -> &[[u32; 2]] {
        &self.0
    }

    /// Sets a value of an entry of a file. Entries without samples fill up the lists of a file.
    pub(crate) fn set(&mut self, entry: usize, value: usize, number: u32) {
        self.0.resize(self.0.len().max(entry + 1), [NO_SURFACE, 0]);
        self.0[entry][value] = number;
    }

    /// Drops entries without samples.
    pub(crate) fn drop_empty(&mut self) {
        self.0.retain(|[_, count]| *count > 0);
    }

    /// The identifiers of surfaces with the fractions of the samples that show them, the greatest fraction first.
    pub(crate) fn ranked(&self) -> Vec<[f32; 2]> {
        let total: f64 = self.0.iter().map(|[_, count]| f64::from(*count)).sum();
        let mut surfaces: Vec<[u32; 2]> = self.0.iter().copied().filter(|[id, _]| *id != NO_SURFACE).collect();
        surfaces.sort_by_key(|[_, count]| std::cmp::Reverse(*count));
        let coverage = |count: u32| snowblue_base::narrow(f64::from(count) / total);
        surfaces.into_iter().map(|[id, count]| [f32::from_bits(id), coverage(count)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hashes by the module mmh3 of Python.
    #[test]
    fn hashes_are_those_of_murmur3() {
        for (name, hash) in [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("box", 0x0a4a_777b),
            ("hello", 0x248b_fa47),
            ("Snow Drift", 0x3efd_1daf),
            ("igloo.glb roof", 0x1255_bf40),
            ("Schnee auf Gelände", 0x4271_d492),
            ("CryptoObject", 0x3ae3_9a58),
            ("CryptoMaterial", 0xbe35_9d67),
        ] {
            assert_eq!(murmur3(name.as_bytes()), hash, "{name}");
        }
    }

    #[test]
    fn identifiers_are_normal_floats() {
        for number in 0..20_000 {
            let (name, hash) = (number.to_string(), murmur3(number.to_string().as_bytes()));
            let id = id(&name);
            assert!(f32::from_bits(id).is_normal(), "{name}");
            assert!(id == hash || !f32::from_bits(hash).is_normal() && (id ^ hash).count_ones() == 1, "{name}");
        }
    }

    #[test]
    fn coverage_is_ranked_and_leaves_the_sky_out() {
        let mut counts = IdCounts::default();
        for (id, count) in [(9, 1), (NO_SURFACE, 4), (7, 2), (9, 1), (8, 1)] {
            counts.add(id, count);
        }
        let mut twice = counts.clone();
        twice.add_all(&counts);
        assert_eq!(twice.entries(), [[0, 8], [7, 4], [8, 2], [9, 4]]);
        for counts in [counts, twice] {
            let ids = counts.ranked().into_iter().map(|[id, coverage]| (id.to_bits(), coverage.to_bits()));
            let part = |ninths: f64| snowblue_base::narrow(ninths / 9.0).to_bits();
            assert_eq!(ids.collect::<Vec<_>>(), [(7, part(2.0)), (9, part(2.0)), (8, part(1.0))]);
        }
        let mut read = IdCounts::default();
        [(1, 1, 3), (1, 0, 7), (0, 0, 0), (0, 1, 5), (2, 0, 0), (2, 1, 0)]
            .into_iter()
            .for_each(|(entry, value, number)| read.set(entry, value, number));
        read.drop_empty();
        assert_eq!(read.entries(), [[0, 5], [7, 3]]);
    }
}
