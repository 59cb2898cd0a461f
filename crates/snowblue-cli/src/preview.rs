//! A picture in tev while it grows (Thomas Müller's viewer, github.com/Tom94/tev), over its TCP protocol.

use std::io;
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use snowblue_color::LinearRgb;
use snowblue_render::FilmAccumulator;
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::failure::Failure;

/// Where tev listens if it is told nothing else.
pub(crate) const TEV: &str = "127.0.0.1:14158";

/// How long a viewer may take to answer.
const PATIENCE: Duration = Duration::from_secs(5);

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A picture that a viewer shows.
pub(crate) struct Preview {
    client: TevClient,
    name: String,
    is_created: bool,
}

impl Preview {
    /// Connects to a viewer.
    pub(crate) fn connect(address: &str, name: String) -> Result<Self, Failure> {
        // A name may have several addresses, such as those of IPv6 and IPv4, and tev listens at one of them.
        let connected = address.to_socket_addrs().and_then(|places| {
            let mut answer = Err(io::Error::other("no such host"));
            for place in places {
                answer = TcpStream::connect_timeout(&place, PATIENCE);
                if answer.is_ok() {
                    break;
                }
            }
            let stream = answer?;
            // A viewer that hangs must not hold up the work.
            stream.set_write_timeout(Some(PATIENCE))?;
            Ok(stream)
        });
        match connected {
            Ok(stream) => Ok(Self { client: TevClient::wrap(stream), name, is_created: false }),
            Err(error) => Err(Failure::Input(format!("--tev {address}: no viewer answers there: {error}"))),
        }
    }

    /// Shows the picture as it is now, in linear sRGB.
    pub(crate) fn show(&mut self, sums: &FilmAccumulator) -> io::Result<()> {
        let (width, height) = sums.size();
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
            #[expect(clippy::cast_possible_truncation, reason = "viewers take single precision")]
            let value = value as f32;
            value
        };
        let colours = sums.film().pixels().iter().map(|xyz| LinearRgb::from_xyz(*xyz)).collect::<Vec<_>>();
        let data: Vec<f32> = colours.iter().flat_map(|colour| [colour.r, colour.g, colour.b].map(single)).collect();
        let window = sums.window();
        self.client.send(PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: &CHANNELS,
            channel_offsets: &[0, 1, 2],
            channel_strides: &[3, 3, 3],
            x: window.columns.start,
            y: window.rows.start,
            width: window.width(),
            height: window.height(),
            data: &data,
        })
    }
}
