//! `snowblue merge`: parts that were made apart become one.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_database::file::{self, AnyTable};
use snowblue_database::shard::{self, Shard};
use snowblue_render::film::exposure::Exposure;

use crate::database::Compression;
use crate::failure::{Failure, Outcome};
use crate::merge_pictures::merge_pictures;
use crate::parse;
use crate::picture::PictureFile;
use crate::report::{check_table_place, tell};

/// How an OpenEXR file begins.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Put parts of a picture together (render --spp-range, --crop), or all shards of a table (database build --shard)
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "What is merged is what one run makes, to the last bit. The parts of a picture are of one scene, seed and table; \
they may be ranges of samples, tiles, or both, in any order, but no sample may be in two of them.

Examples:
  snowblue render scene.toml --spp-range 0:50 -o part1.exr    (and 50:100, elsewhere)
  snowblue merge part1.exr part2.exr -o whole.exr
  snowblue merge tile*.exr -o whole.png --exposure -1
  snowblue merge part*.exr --keep-sums -o half.exr    (to be merged again, or resumed)
  snowblue database build --shard 1/3 -o part1.nc    (and 2/3, 3/3, on machines of one kind)
  snowblue merge part1.nc part2.nc part3.nc -o full.nc
  snowblue merge part*.nc --space log --components 3 -o snow.nc"
)]
pub(crate) struct Merge {
    /// Every part, in any order
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Keep in a merged .exr what further merging and render --resume go on from
    #[arg(long)]
    keep_sums: bool,
    /// Brightness of a PNG in stops, or 'auto' [default: the one that the parts were rendered for]
    #[arg(long, value_name = "STOPS", value_parser = parse::exposure, allow_negative_numbers = true)]
    exposure: Option<Exposure>,
    /// Where to write the whole: .exr or .png of a picture, .nc (NetCDF) of a table
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    compression: Compression,
}

impl Merge {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        let pictures = self.parts.iter().map(|path| is_picture(path)).collect::<Result<Vec<bool>, Failure>>()?;
        if let Some(odd) = pictures.iter().position(|is_picture| *is_picture != pictures[0]) {
            let kind = |is_picture: bool| if is_picture { "a picture" } else { "no picture" };
            return Err(Failure::Input(format!(
                "{} is {}, but {} is {}: only parts of one kind can be merged",
                self.parts[0].display(),
                kind(pictures[0]),
                self.parts[odd].display(),
                kind(pictures[odd])
            )));
        }
        let said = if pictures[0] { self.merge_pictures() } else { self.merge_shards() }?;
        if !quiet {
            tell(&format!("{}: {said}\n", self.output.display()));
        }
        Ok(())
    }

    fn merge_pictures(&self) -> Result<String, Failure> {
        if self.compression.is_asked() {
            return Err(Failure::Input("--space is for tables, but these parts are pictures".to_owned()));
        }
        let file = PictureFile::new(&self.output, self.keep_sums)?;
        if self.keep_sums {
            file.needs_exr("--keep-sums")?;
        }
        merge_pictures(&self.parts, &file, self.exposure)
    }

    fn merge_shards(&self) -> Result<String, Failure> {
        if self.keep_sums || self.exposure.is_some() {
            return Err(Failure::Input(
                "--keep-sums and --exposure are for pictures, but these parts are none".to_owned(),
            ));
        }
        check_table_place(&self.output)?;
        self.compression.check()?;
        let shards: Result<Vec<(String, Shard)>, Failure> = self.parts.iter().map(|path| read(path)).collect();
        let table = shard::merge(&shards?).map_err(Failure::input)?;
        let kept = self.compression.write(&table, &self.output)?;
        Ok(format!("{} curves of {} shards{kept}", table.axes.curves(), self.parts.len()))
    }
}

/// Whether a file is an OpenEXR picture, by its content.
fn is_picture(path: &Path) -> Result<bool, Failure> {
    let mut start = Vec::new();
    match File::open(path).and_then(|file| file.take(EXR.len() as u64).read_to_end(&mut start)) {
        Ok(_) => Ok(start == EXR),
        Err(error) => Err(Failure::Input(format!("cannot read {}: {error}", path.display()))),
    }
}

fn read(path: &Path) -> Result<(String, Shard), Failure> {
    let name = path.display().to_string();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Shard(shard) => Ok((name, shard)),
        other => Err(Failure::Input(format!("{name}: is {}, not a shard", other.kind()))),
    }
}
