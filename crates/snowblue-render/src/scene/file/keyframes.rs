//! Values of a scene file that change over a film.
//!
//! ```toml
//! [keyframes]
//! camera.position = [[0, -3, 1], [0, -2, 1], [1, -2, 1]]
//! light.0.radiant_intensity_w_sr = { at = [0, 0.25, 1], values = [0, 5, 5] }
//! ```
//!
//! Each key is that of a value of the scene. A frame of the film is the scene of the file with one value at each key.

use std::fmt::Display;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::scene::description::KeyPath;
use crate::scene::file::message::Mistake;

/// The name of the table.
pub(super) const KEYFRAMES: &str = "keyframes";

/// Most values that change. The text of the scene is read again for each.
const MOST_TRACKS: usize = 256;

/// The values that change over a film.
#[derive(Debug, Clone, Default)]
pub(super) struct Keyframes(Vec<Track>);

/// A value that changes.
#[derive(Debug, Clone)]
struct Track {
    /// The keys from the outermost table to the value. An item of a list has its number.
    keys: Vec<String>,
    /// Where in the film the values are, ascending from 0, the first frame, to 1, the last.
    positions: Vec<f64>,
    values: Vec<Spanned<Value>>,
    /// Whether the scene takes whole numbers only.
    is_whole: bool,
}

/// A value at one position.
#[derive(Debug, Clone)]
enum Value {
    Number(f64),
    /// A time of day, in seconds since midnight.
    Time(f64),
    List(Vec<Spanned<Value>>),
    /// Other text, true or false: nothing lies in between.
    Other(toml::Value),
}

impl Keyframes {
    /// Reads the keyframes of a text. `can_read` says whether a document describes a scene.
    pub(super) fn new(text: &str, can_read: &dyn Fn(Spanned<DeTable>) -> bool) -> Result<Self, Mistake> {
        let mut keyframes = Self::default();
        if let Some(table) = DeTable::parse(text)?.get_ref().get(KEYFRAMES) {
            keyframes.read(table, &mut Vec::new())?;
        }
        for number in 0..keyframes.0.len() {
            // A value that may have no fraction is a whole number.
            let mut with_fraction = keyframes.clone();
            if with_fraction.0[number].add_fraction() {
                keyframes.0[number].is_whole = !with_fraction.frame(text, 0.0, can_read)?;
            }
        }
        Ok(keyframes)
    }

    /// Whether nothing changes.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What `read` makes of the document of a frame, without the table of keyframes.
    pub(super) fn frame<T>(
        &self,
        text: &str,
        position: f64,
        read: impl FnOnce(Spanned<DeTable>) -> T,
    ) -> Result<T, Mistake> {
        // What is read borrows from these texts.
        let values: Vec<(&Spanned<Value>, String)> = self.0.iter().map(|track| track.value(position)).collect();
        let mut document = DeTable::parse(text)?;
        let scene = document.get_mut();
        scene.remove(KEYFRAMES);
        for (track, (place, value)) in self.0.iter().zip(&values) {
            let value = with_places(DeValue::parse(value)?.into_inner(), place);
            set_in_table(scene, &track.keys, &KeyPath::default(), value)?;
        }
        Ok(read(document))
    }

    /// Reads the values below a table, to which `keys` lead.
    fn read(&mut self, value: &Spanned<DeValue>, keys: &mut Vec<String>) -> Result<(), Mistake> {
        let is_track = |table: &DeTable| table.contains_key("at") && table.contains_key("values");
        let track = match value.get_ref() {
            DeValue::Array(_) if !keys.is_empty() => Track::new(keys, None, value)?,
            DeValue::Table(table) if is_track(table) => Track::new(keys, Some(&table["at"]), &table["values"])?,
            DeValue::Table(table) => {
                for (key, value) in table {
                    keys.push(key.get_ref().to_string());
                    self.read(value, keys)?;
                    keys.pop();
                }
                return Ok(());
            }
            _ => {
                let reason = "must be a list of values, or { at = [0, 1], values = [..., ...] }";
                return Err(wrong(value, keys, reason));
            }
        };
        if self.0.len() == MOST_TRACKS {
            return Err(wrong(value, keys, format!("must be one of at most {MOST_TRACKS} values that change")));
        }
        self.0.push(track);
        Ok(())
    }
}

impl Track {
    /// Values at positions, or at equal distances.
    fn new(keys: &[String], at: Option<&Spanned<DeValue>>, list: &Spanned<DeValue>) -> Result<Self, Mistake> {
        let Some(items) = list.get_ref().as_array().filter(|items| items.len() >= 2) else {
            return Err(wrong(list, keys, "must have two values or more"));
        };
        let values: Vec<Spanned<Value>> = items.iter().map(|item| Value::new(keys, item)).collect::<Result<_, _>>()?;
        if let Some(odd) = values.iter().position(|value| !value.get_ref().is_like(values[0].get_ref())) {
            let reason = "must have values of one kind: numbers, lists of as many numbers, times of day, or words";
            return Err(wrong(&items[odd], keys, reason));
        }
        let positions = match at {
            None => (0..values.len()).map(|number| number as f64 / (values.len() - 1) as f64).collect(),
            Some(at) => {
                let numbers = at.get_ref().as_array().into_iter().flatten();
                let numbers: Vec<f64> = numbers.filter_map(|item| number_of(item.get_ref())).collect();
                let is_within = |number: &f64| (0.0..=1.0).contains(number);
                if numbers.len() != values.len() || !numbers.iter().all(is_within) || !numbers.is_sorted() {
                    let reason = "must have as many positions as values, ascending from 0, the first frame, to 1";
                    return Err(wrong(at, keys, reason));
                }
                numbers
            }
        };
        Ok(Self { keys: keys.to_vec(), positions, values, is_whole: false })
    }

    /// The value at a position as TOML, and the key before. Before the first key and after the last it is theirs.
    fn value(&self, position: f64) -> (&Spanned<Value>, String) {
        let later = self.positions.partition_point(|key| *key <= position);
        let (earlier, later) = (later.saturating_sub(1), later.min(self.positions.len() - 1));
        let way = self.positions[later] - self.positions[earlier];
        let share = if way > 0.0 { (position - self.positions[earlier]) / way } else { 0.0 };
        let value = self.values[earlier].get_ref().between(self.values[later].get_ref(), share, self.is_whole);
        (&self.values[earlier], value.to_string())
    }

    /// Adds ½ to all numbers; false if there are none, or one has a fraction already.
    fn add_fraction(&mut self) -> bool {
        let mut numbers = Vec::new();
        self.values.iter_mut().for_each(|value| value.get_mut().numbers(&mut numbers));
        let are_whole = !numbers.is_empty() && numbers.iter().all(|number| number.fract() == 0.0);
        numbers.into_iter().for_each(|number| *number += 0.5);
        are_whole
    }
}

impl Value {
    fn new(keys: &[String], item: &Spanned<DeValue>) -> Result<Spanned<Self>, Mistake> {
        let value = match item.get_ref() {
            DeValue::Table(_) => return Err(wrong(item, keys, "has tables as values; each of their keys has its own")),
            DeValue::Array(items) => {
                Self::List(items.iter().map(|item| Self::new(keys, item)).collect::<Result<_, _>>()?)
            }
            DeValue::Integer(_) | DeValue::Float(_) => {
                Self::Number(number_of(item.get_ref()).ok_or_else(|| wrong(item, keys, "has a number out of range"))?)
            }
            DeValue::String(text) => seconds_of_day(text).map_or(Self::Other(text.as_ref().into()), Self::Time),
            DeValue::Boolean(flag) => Self::Other((*flag).into()),
            DeValue::Datetime(time) => Self::Other((*time).into()),
        };
        Ok(Spanned::new(item.span(), value))
    }

    /// Whether something lies between both, or neither has anything in between.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Number(_), Self::Number(_)) | (Self::Time(_), Self::Time(_)) => true,
            (Self::List(ones), Self::List(others)) => {
                ones.len() == others.len()
                    && ones.iter().zip(others).all(|(one, other)| one.get_ref().is_like(other.get_ref()))
            }
            (Self::Other(one), Self::Other(other)) => one.same_type(other),
            _ => false,
        }
    }

    /// Collects all numbers.
    fn numbers<'v>(&'v mut self, found: &mut Vec<&'v mut f64>) {
        match self {
            Self::Number(number) => found.push(number),
            Self::List(items) => items.iter_mut().for_each(|item| item.get_mut().numbers(found)),
            Self::Time(_) | Self::Other(_) => {}
        }
    }

    /// The value between this and another of its kind.
    fn between(&self, other: &Self, share: f64, is_whole: bool) -> toml::Value {
        let between = |one: f64, other: f64| one + share * (other - one);
        match (self, other) {
            (Self::Number(one), Self::Number(other)) if is_whole => whole(between(*one, *other)).into(),
            (Self::Number(one), Self::Number(other)) => between(*one, *other).into(),
            (Self::Time(one), Self::Time(other)) => time_of_day(between(*one, *other)).into(),
            (Self::List(ones), Self::List(others)) => {
                let pairs = ones.iter().zip(others);
                let items = pairs.map(|(one, other)| one.get_ref().between(other.get_ref(), share, is_whole));
                toml::Value::Array(items.collect())
            }
            (Self::Other(value), _) => value.clone(),
            _ => unreachable!("the values of a key are of one kind"),
        }
    }
}

/// Gives a value the places of another in the text.
fn with_places<'text>(value: DeValue<'text>, places: &Spanned<Value>) -> Spanned<DeValue<'text>> {
    let placed = match (value, places.get_ref()) {
        (DeValue::Array(items), Value::List(places)) => {
            let items = items.into_iter().zip(places);
            DeValue::Array(items.map(|(item, place)| with_places(item.into_inner(), place)).collect())
        }
        (value, _) => value,
    };
    Spanned::new(places.span(), placed)
}

/// Sets the value to which keys lead from a table. Tables on the way that are missing are added.
fn set_in_table<'text>(
    table: &mut DeTable<'text>,
    keys: &[String],
    path: &KeyPath,
    value: Spanned<DeValue<'text>>,
) -> Result<(), Mistake> {
    let Some((key, keys)) = keys.split_first() else { return Ok(()) };
    let path = path.key(key);
    let empty = Spanned::new(value.span(), DeValue::Table(DeTable::new()));
    let inner = table.entry(Spanned::new(value.span(), key.clone().into())).or_insert(empty);
    set(inner, keys, &path, value)
}

/// Sets the value to which keys lead from another.
fn set<'text>(
    outer: &mut Spanned<DeValue<'text>>,
    keys: &[String],
    path: &KeyPath,
    value: Spanned<DeValue<'text>>,
) -> Result<(), Mistake> {
    let Some((key, rest)) = keys.split_first() else {
        *outer = value;
        return Ok(());
    };
    let count = match outer.get_mut() {
        DeValue::Table(table) => return set_in_table(table, keys, path, value),
        DeValue::Array(items) => {
            let count = items.len();
            if let Some((index, item)) = key.parse().ok().and_then(|index| Some((index, items.get_mut(index)?))) {
                return set(item, rest, &path.index(index), value);
            }
            count
        }
        _ => {
            return Err(Mistake { span: value.span(), reason: format!("{path} is a single value and has no `{key}`") });
        }
    };
    let reason = format!("{path} has no item `{key}`; they are counted from 0, and there are {count}");
    Err(Mistake { span: value.span(), reason })
}

/// A mistake in the keyframes of a value.
fn wrong(place: &Spanned<DeValue>, keys: &[String], reason: impl Display) -> Mistake {
    let path: Vec<&str> = std::iter::once(KEYFRAMES).chain(keys.iter().map(String::as_str)).collect();
    Mistake { span: place.span(), reason: format!("{} {reason}", path.join(".")) }
}

/// A whole or a decimal number.
fn number_of(value: &DeValue) -> Option<f64> {
    match value {
        #[expect(clippy::cast_precision_loss, reason = "beyond 2^53 no quantity of a scene is valid")]
        DeValue::Integer(number) => {
            i64::from_str_radix(number.as_str(), number.radix()).ok().map(|number| number as f64)
        }
        DeValue::Float(number) => number.as_str().parse().ok(),
        _ => None,
    }
}

/// The nearest whole number.
fn whole(number: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "beyond 2^53 no quantity of a scene is valid")]
    let number = number.round() as i64;
    number
}

/// The seconds since midnight of `HH:MM` or `HH:MM:SS`.
fn seconds_of_day(text: &str) -> Option<f64> {
    let mut seconds = 0;
    let mut parts = text.split(':');
    for (unit, most) in [(3600, 23), (60, 59), (1, 59)] {
        // Seconds may be missing.
        let part = parts.next().or((unit == 1).then_some("00"))?;
        let is_number = part.len() == 2 && part.bytes().all(|byte| byte.is_ascii_digit());
        seconds += unit * part.parse::<u32>().ok().filter(|part| is_number && *part <= most)?;
    }
    parts.next().is_none().then_some(f64::from(seconds))
}

/// The time of day of seconds since midnight, to the millisecond: `HH:MM:SS`, where necessary with a fraction.
fn time_of_day(seconds: f64) -> String {
    let milliseconds = whole(1e3 * seconds);
    let (seconds, fraction) = (milliseconds / 1000, milliseconds % 1000);
    let clock = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
    if fraction == 0 { clock } else { format!("{clock}.{fraction:03}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::{LightSource, SceneDescription};
    use crate::scene::file::SceneFile;
    use crate::scene::integrator::IntegratorKind;

    const SCENE: &str = "[camera]\nposition = [0, -3, 1]\nlook_at = [0, 0, 0]\n\
        [[light]]\ntype = \"sphere\"\nposition = [0, 0, 9]\nradius = 0.5\nradiance_w_m2_sr = 1\n";

    /// The frames 0 to `count` − 1 of a scene with keyframes.
    fn frames(keyframes: &str, count: u32) -> Result<Vec<SceneDescription>, String> {
        let file = SceneFile::parse(format!("{SCENE}[keyframes]\n{keyframes}"), "scene.toml");
        let file = file.map_err(|error| error.to_string())?;
        let frame = |number| file.frame(number, count).map(|frame| frame.description);
        (0..count).map(frame).collect::<Result<_, _>>().map_err(|error| error.to_string())
    }

    /// A number in each frame.
    fn numbers(keyframes: &str, count: u32, of: impl Fn(&SceneDescription) -> f64) -> Vec<f64> {
        frames(keyframes, count).unwrap().iter().map(of).collect()
    }

    fn radiance(scene: &SceneDescription) -> f64 {
        match &scene.lights[0].source {
            LightSource::Sphere(light) => light.radiance_w_m2_sr,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn numbers_lie_on_straight_lines_between_their_keys() {
        let camera = "camera.position = [[0, -3, 1], [0, -2, 1], [1, -2, 1.5]]";
        let positions: Vec<_> =
            frames(camera, 5).unwrap().iter().map(|scene| scene.camera.as_ref().unwrap().position).collect();
        let expected = [[0.0, -3.0, 1.0], [0.0, -2.5, 1.0], [0.0, -2.0, 1.0], [0.5, -2.0, 1.25], [1.0, -2.0, 1.5]];
        assert_eq!(positions, expected);
        // An item of a list, and a key that the file lacks.
        let height = "camera.position.2 = [1, 2]\ncamera.vertical_fov_deg = [40, 45]";
        let camera = |scene: &SceneDescription| scene.camera.clone().unwrap();
        assert_eq!(numbers(height, 3, |scene| camera(scene).position[2]), [1.0, 1.5, 2.0]);
        assert_eq!(numbers(height, 3, |scene| camera(scene).vertical_fov_deg), [40.0, 42.5, 45.0]);
    }

    #[test]
    fn keys_have_positions_in_the_film() {
        let lamp = "light.0.radiance_w_m2_sr = { at = [0.25, 0.5, 1], values = [1, 5, 6] }";
        assert_eq!(numbers(lamp, 9, radiance), [1.0, 1.0, 1.0, 3.0, 5.0, 5.25, 5.5, 5.75, 6.0]);
        let switched_on = "light.0.radiance_w_m2_sr = { at = [0, 0.5, 0.5, 1], values = [0, 0, 4, 4] }";
        assert_eq!(numbers(switched_on, 5, radiance), [0.0, 0.0, 4.0, 4.0, 4.0]);
        assert_eq!(numbers(switched_on, 1, radiance), [0.0], "a film of one frame is the first");
    }

    #[test]
    fn whole_numbers_stay_whole() {
        let seeds = "integrator.seed = [1, 4]\nfilm.width = [10, 20]\nfilm.height = [10, 20]";
        assert_eq!(numbers(seeds, 5, |scene| scene.integrator.seed.into()), [1.0, 2.0, 3.0, 3.0, 4.0]);
        assert_eq!(numbers(seeds, 3, |scene| scene.film.width.into()), [10.0, 15.0, 20.0]);
    }

    #[test]
    fn words_hold_until_the_next() {
        let kinds = "integrator.type = { at = [0, 0.75], values = [\"diffusion\", \"hybrid\"] }\n\
                     light.0.visible = [true, false]";
        let found: Vec<_> = frames(kinds, 5).unwrap().iter().map(|scene| scene.integrator.kind).collect();
        let (early, late) = (IntegratorKind::Diffusion, IntegratorKind::Hybrid);
        assert_eq!(found, [early, early, early, late, late]);
        let visible = |scene: &SceneDescription| match &scene.lights[0].source {
            LightSource::Sphere(light) => f64::from(u8::from(light.visible)),
            other => panic!("{other:?}"),
        };
        assert_eq!(numbers(kinds, 3, visible), [1.0, 1.0, 0.0]);
    }

    #[test]
    fn times_of_day_pass_evenly() {
        for (text, seconds) in [("08:00", 28_800.0), ("17:30:15", 63_015.0), ("00:00", 0.0), ("23:59:59", 86_399.0)] {
            assert_eq!(seconds_of_day(text), Some(seconds));
        }
        for text in ["24:00", "8:00", "08:60", "08", "08:00:00:00", "+8:00", "noon"] {
            assert_eq!(seconds_of_day(text), None, "{text}");
        }
        let text = "[keyframes]\nsky.sun.time = [\"08:00\", \"17:00:01\"]\n";
        let keyframes = Keyframes::new(text, &|_| true).unwrap();
        for (position, expected) in [(0.0, "08:00:00"), (0.5, "12:30:00.500"), (1.0, "17:00:01")] {
            let time = keyframes.frame(text, position, |document| {
                let sky = document.get_ref()["sky"].get_ref().get("sun").unwrap().get_ref();
                sky.get("time").unwrap().get_ref().as_str().map(str::to_owned)
            });
            assert_eq!(time.unwrap().unwrap(), expected);
        }
    }

    /// The scene has 8 lines, and `[keyframes]` is the ninth.
    #[test]
    fn mistakes_are_at_their_keyframes() {
        let cases = [
            ("camera.positon = [1, 2]", "scene.toml:10: unknown key `positon` in camera"),
            (
                "\nlight.1.radius = [1, 2]",
                "scene.toml:11: light has no item `1`; they are counted from 0, and there are 1",
            ),
            ("light.0.radius = [1, -2]", "scene.toml:10: light[0].radius is -2 m, but must lie in 0.000001"),
            ("camera.position.0.x = [1, 2]", "scene.toml:10: camera.position[0] is a single value and has no `x`"),
            ("camera.position = [[0, 1], [2, 3]]", "scene.toml:10: camera.position is length 2, but must be"),
            ("camera.vertical_fov_deg = [40]", "keyframes.camera.vertical_fov_deg must have two values or more"),
            ("camera.vertical_fov_deg = 40", "keyframes.camera.vertical_fov_deg must be a list of values, or { at ="),
            ("film.exposure = [\"auto\", 2]", "keyframes.film.exposure must have values of one kind"),
            ("camera.position = [[0, 1, 2], [3, 4]]", "keyframes.camera.position must have values of one kind"),
            ("camera = [{ up = [0, 0, 1] }, 1]", "keyframes.camera has tables as values"),
            (
                "light.0.radius = { at = [0, 2], values = [1, 2] }",
                "keyframes.light.0.radius must have as many positions",
            ),
            (
                "light.0.radius = { at = [1, 0], values = [1, 2] }",
                "keyframes.light.0.radius must have as many positions",
            ),
            ("light.0.radius = { at = [0], values = [1, 2] }", "keyframes.light.0.radius must have as many positions"),
            ("skies.sun = [1, 2]", "scene.toml:10: unknown table `skies`"),
        ];
        for (keyframes, expected) in cases {
            let error = frames(keyframes, 2).unwrap_err();
            assert!(error.contains(expected), "{keyframes}: {error}");
        }
        let error = SceneFile::parse("keyframes = 3\n", "scene.toml").unwrap_err().to_string();
        assert!(error.contains("keyframes must be"), "{error}");
    }

    #[test]
    fn a_frame_is_plain_data() {
        let scene = frames("camera.position.0 = [0, 1]\nlight.0.radiance_w_m2_sr = [0, 3]", 7).unwrap();
        let text = scene[2].to_toml();
        assert_eq!(SceneFile::parse(text, "again.toml").unwrap().description, scene[2]);
    }
}
