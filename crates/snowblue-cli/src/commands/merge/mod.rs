//! `snowblue merge`: merges parts of a picture, or the shards of a table; makes a PNG of a finished EXR; compresses a
//! full table.

mod finished;
mod pictures;

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_database::Table;
use snowblue_database::file::{self, AnyTable};
use snowblue_database::shard::{self, NamedShard};
use snowblue_render::film::resumable_file::ResumableImage;

use crate::options::{Compression, DevelopmentOptions, FilmMemory, GivenOptions, Idle};
use crate::output::{
    Failure, Outcome, PictureFile, PictureFormat, check_not_input, check_table_path, output_path, print_notes,
};
use finished::develop;
use pictures::merge_pictures;

/// Magic number of OpenEXR.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Merge parts of a picture (render --spp-range, --crop), or all shards of a table (database build --shard); make a PNG
/// of any EXR
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "The result is identical to that of a single run, to the last bit. The parts of a picture must have \
one scene, seed and table. They can be ranges of samples, tiles, or both, in any order; the samples of a pixel \
must make one range. --exposure, --tone and --white set how a .png shows its light, without rendering again. Its \
source is parts, or any single .exr with linear RGB, also of another program: the channels R, G and B, or the first \
layer that has them.

Examples:
  snowblue render scene.toml --spp-range 0:50 -o part1.exr    (and 50:100, elsewhere)
  snowblue merge part1.exr part2.exr -o whole.exr
  snowblue merge tile*.exr -o whole.png --exposure -1
  snowblue merge picture.exr -o other.png --exposure auto --white 5000K --tone agx
  snowblue merge part*.exr --keep-sums -o half.exr    (to be merged again, or resumed)
  snowblue database build --shard 1/3 -o part1.nc    (and 2/3, 3/3, on machines of one kind)
  snowblue merge part1.nc part2.nc part3.nc -o full.nc
  snowblue merge part*.nc --space log --components 3 -o snow.nc
  snowblue merge full.nc --space log --components 3 -o snow.nc    (compresses a full table)"
)]
pub(crate) struct Merge {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    /// Parts to merge, in any order
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Keep the sums of samples in a merged .exr, for further merging and render --resume
    #[arg(long)]
    keep_sums: bool,
    #[command(flatten)]
    development: DevelopmentOptions,
    /// File to write: .exr or .png for a picture, .nc (NetCDF) for a table
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
    #[command(flatten)]
    film_memory: FilmMemory,
    #[command(flatten)]
    compression: Compression,
}

impl Merge {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.parts.iter().try_for_each(|part| check_not_input(part, &self.output))?;
        let kinds = self.parts.iter().map(|path| PartKind::of(path)).collect::<Result<Vec<PartKind>, Failure>>()?;
        if let Some(odd) = kinds.iter().position(|kind| *kind != kinds[0]) {
            return Err(Failure::Input(format!(
                "{} is {}, but {} is {}: parts must be of one kind",
                self.parts[0].display(),
                kinds[0].name(),
                self.parts[odd].display(),
                kinds[odd].name()
            )));
        }
        let summary = match kinds[0] {
            PartKind::Picture => self.merge_pictures(quiet),
            PartKind::Table => self.merge_shards(),
        }?;
        print_notes(quiet, [format!("{}: {summary}", self.output.display())]);
        Ok(())
    }

    fn merge_pictures(&self, quiet: bool) -> Result<String, Failure> {
        self.given.refuse_idle(&[Idle {
            when: true,
            options: &["space"],
            why: "it is for tables, but the parts are pictures",
        }])?;
        let file = PictureFile::new(&self.output, self.keep_sums)?;
        if self.keep_sums {
            file.needs_exr("--keep-sums")?;
        }
        self.given.refuse_idle(&[Idle {
            when: file.format == PictureFormat::Exr,
            options: &["white"],
            why: "an .exr keeps the colours of its parts; it is for a .png",
        }])?;
        if let [part] = &*self.parts
            && file.format == PictureFormat::Png
            && ResumableImage::open_if_resumable(part).map_err(Failure::input)?.is_none()
        {
            return develop(part, &file, self.development, self.film_memory, quiet);
        }
        merge_pictures(&self.parts, &file, self.development, self.film_memory)
    }

    fn merge_shards(&self) -> Result<String, Failure> {
        self.given.refuse_idle(&[Idle {
            when: true,
            options: &["keep_sums", "exposure", "tone", "white", "film_memory_mib"],
            why: "it is for pictures, but the parts are tables",
        }])?;
        check_table_path(&self.output)?;
        self.compression.check()?;
        let table = self.whole_table()?;
        let kept = self.compression.write(&table, &self.output)?;
        let files = if self.parts.len() == 1 { "file" } else { "files" };
        Ok(format!("{} curves from {} {files}{kept}", table.axes.curves(), self.parts.len()))
    }

    /// The table of all shards, or the only part if this part is a full table.
    fn whole_table(&self) -> Result<Table, Failure> {
        let mut shards = Vec::with_capacity(self.parts.len());
        for path in &self.parts {
            let name = path.display().to_string();
            match file::read(path).map_err(Failure::input)? {
                AnyTable::Shard(shard) => shards.push(NamedShard { name, shard }),
                AnyTable::Full(table) if self.parts.len() == 1 => return Ok(table),
                other @ (AnyTable::Full(_) | AnyTable::Compressed(_)) => {
                    return Err(Failure::Input(format!("{name}: is {}, not a shard", other.kind())));
                }
            }
        }
        shard::merge(&shards).map_err(Failure::input)
    }
}

/// The kind of a part, by the first bytes of its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PartKind {
    /// OpenEXR.
    Picture,
    /// NetCDF.
    Table,
}

impl PartKind {
    fn of(path: &Path) -> Result<Self, Failure> {
        let refused = |what: &str| Failure::Input(format!("{}: {what}", path.display()));
        let mut start = Vec::new();
        File::open(path)
            .and_then(|file| file.take(EXR_MAGIC.len() as u64).read_to_end(&mut start))
            .map_err(|error| refused(&format!("cannot be read: {error}")))?;
        match &start[..] {
            [] => Err(refused("is empty")),
            start if start == EXR_MAGIC => Ok(Self::Picture),
            // The classic format, and the format of NetCDF-4, which the reader refuses.
            start if start.starts_with(b"CDF") || start == b"\x89HDF" => Ok(Self::Table),
            _ => Err(refused("is neither a picture (.exr) nor a table (.nc)")),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Picture => "a picture",
            Self::Table => "a table",
        }
    }
}
