//! The macro behind the list of all kinds of lights.

/// Makes `LightSource` of the kinds of lights: for each the value of `type`, the name of its variant, its file, and the
/// name of its keys there.
macro_rules! light_sources {
    ($($(#[$doc:meta])* $name:literal => $kind:ident($file:ident::$keys:ident),)*) => {
        /// The keys of all kinds.
        pub(crate) mod descriptions {
            pub use $crate::light::LightSource;
            $(pub use $crate::light::$file::$keys;)*
        }

        /// The geometry and the strength of a light.
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        #[serde(tag = "type")]
        pub enum LightSource {
            $($(#[$doc])* #[serde(rename = $name)] $kind($file::$keys),)*
        }

        impl LightSource {
            /// The values of `type`.
            pub(crate) const TYPES: &[&str] = &[$($name),*];

            /// Reads the light of a type from the table at a path, which may have the keys `known` as well; none if
            /// there is no such type.
            pub(crate) fn read(
                kind: &str,
                table: &toml::Spanned<toml::de::DeValue>,
                path: &snowblue_base::KeyPath,
                known: &[&str],
            ) -> Option<Result<Self, snowblue_base::toml_value::Mistake>> {
                match kind {
                    $($name => Some(snowblue_base::toml_value::read(table, path, known).map(Self::$kind)),)*
                    _ => None,
                }
            }

            /// The keys of whatever kind.
            pub(crate) fn keys(&self) -> &dyn keys::LightKeys {
                match self {
                    $(Self::$kind(keys) => keys,)*
                }
            }
        }
    };
}

pub(super) use light_sources;
