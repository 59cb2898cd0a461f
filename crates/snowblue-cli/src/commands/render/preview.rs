//! Live preview in tev (Thomas Müller's image viewer, github.com/Tom94/tev) over TCP.

use std::io;
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use snowblue_color::{LinearRgb, Xyz};
use snowblue_render::film::window::Window;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::{Film, FilmAccumulator};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::output::Failure;

/// Default address of tev.
pub(super) const TEV: &str = "127.0.0.1:14158";

/// Time limit of connecting and sending.
const TIMEOUT: Duration = Duration::from_secs(5);

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A connection to the viewer, for one picture.
pub(super) struct Preview {
    client: TevClient,
    name: String,
    is_created: bool,
}

impl Preview {
    /// Connects to a viewer.
    pub(super) fn connect(address: &str, name: String) -> Result<Self, Failure> {
        // A host can have several addresses, such as IPv6 and IPv4; tev listens at one of them.
        let connected = address.to_socket_addrs().and_then(|addresses| {
            let mut answer = Err(io::Error::other("no such host"));
            for address in addresses {
                answer = TcpStream::connect_timeout(&address, TIMEOUT);
                if answer.is_ok() {
                    break;
                }
            }
            let stream = answer?;
            // A viewer that hangs must not block rendering.
            stream.set_write_timeout(Some(TIMEOUT))?;
            Ok(stream)
        });
        match connected {
            Ok(stream) => Ok(Self { client: TevClient::wrap(stream), name, is_created: false }),
            Err(error) => Err(Failure::Input(format!("--tev {address}: cannot connect to a viewer: {error}"))),
        }
    }

    /// Sends the current picture.
    pub(super) fn show(&mut self, sums: &FilmAccumulator) -> io::Result<()> {
        self.send(sums.image_size(), sums.window(), sums.film().pixels())
    }

    /// Sends a first picture.
    pub(super) fn show_first(&mut self, film: &Film) -> io::Result<()> {
        self.send(film.size(), &Window::of_image(film.size()), film.pixels())
    }

    /// Sends the pixels of a window in linear sRGB.
    fn send(&mut self, size: ImageSize, window: &Window, pixels: &[Xyz]) -> io::Result<()> {
        let ImageSize { width, height } = size;
        if !std::mem::replace(&mut self.is_created, true) {
            self.client.send(PacketCreateImage {
                image_name: &self.name,
                grab_focus: true,
                width,
                height,
                channel_names: &CHANNELS,
            })?;
        }
        let single = |value: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "tev takes single precision")]
            let value = value as f32;
            value
        };
        let colours = pixels.iter().map(|xyz| LinearRgb::from_xyz(*xyz));
        let data: Vec<f32> = colours.flat_map(|colour| [colour.r, colour.g, colour.b].map(single)).collect();
        self.client.send(PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: window.columns.start,
            y: window.rows.start,
            width: window.size().width,
            height: window.size().height,
            data: &data,
        })
    }
}
