//! The memory that a picture may take.

use clap::Args;
use snowblue_render::Aovs;
use snowblue_render::film::accumulator::memory_bytes;
use snowblue_render::film::window::Window;

use super::parse;
use crate::output::{Failure, PictureFile};

/// Memory of a film, in MiB, from which on a message is printed.
const WORTH_A_MESSAGE_MIB: u64 = 1024;

/// The greatest memory of a film.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct FilmMemory {
    /// Greatest memory of the pixels of a picture in MiB [16–16777216]
    #[arg(
        long, value_name = "N", default_value_t = 16384, value_parser = parse::whole_number::<u64>(16..=1 << 24)
    )]
    film_memory_mib: u64,
}

impl FilmMemory {
    /// Refuses a picture whose pixels take more memory than allowed. Returns their memory in MiB if it is large.
    pub(crate) fn check(self, file: &PictureFile, windows: &[&Window], aovs: Aovs) -> Result<Option<u64>, Failure> {
        let pixels = windows.iter().map(|window| memory_bytes(window, aovs)).sum::<u64>();
        let output_bytes = file.bytes_per_pixel(aovs);
        let output = windows.first().map_or(0, |window| window.size().pixel_count() as u64 * output_bytes);
        self.check_bytes(file, pixels + output)
    }

    /// Refuses a picture that takes more bytes than allowed. Returns its memory in MiB if it is large.
    pub(crate) fn check_bytes(self, file: &PictureFile, bytes: u64) -> Result<Option<u64>, Failure> {
        let (needed_mib, allowed_mib) = (bytes.div_ceil(1 << 20), self.film_memory_mib);
        if needed_mib > allowed_mib {
            return Err(Failure::Input(format!(
                "{}: the pixels need {needed_mib} MiB of memory, but {allowed_mib} MiB are allowed: raise \
                 --film-memory-mib, or use tiles (render --crop)",
                file.path.display()
            )));
        }
        Ok((needed_mib >= WORTH_A_MESSAGE_MIB).then_some(needed_mib))
    }
}
