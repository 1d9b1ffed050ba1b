//! Which channels belong together: OpenEXR's layers are a matter of names alone.

/// What the layer of the channels without a layer's name is called.
pub const DEFAULT_LAYER: &str = "RGB";

/// A channel's name taken apart: "light.R" is R of "light", "a.b.R" R of "a.b"; "R" and, as some programs write it, ".R" are
/// R of the default layer, whose name is empty.
pub fn layer_and_component(channel: &str) -> (&str, &str) {
    channel.rsplit_once('.').unwrap_or(("", channel))
}

/// A layer's name, and the indices of its channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerChannels {
    /// [`DEFAULT_LAYER`] for channels without the name of one.
    pub name: String,
    /// Where they are in the list of channels.
    pub channels: Vec<usize>,
}

/// The layers of a list of channel names: the default one first, the others by name.
pub fn layers_of<'a>(channels: impl IntoIterator<Item = &'a str>) -> Vec<LayerChannels> {
    let mut layers: Vec<(&str, Vec<usize>)> = Vec::new();
    for (index, channel) in channels.into_iter().enumerate() {
        let (layer, _) = layer_and_component(channel);
        match layers.iter_mut().find(|(name, _)| *name == layer) {
            Some((_, channels)) => channels.push(index),
            None => layers.push((layer, vec![index])),
        }
    }
    layers.sort();
    let named = |name: &str| if name.is_empty() { DEFAULT_LAYER } else { name }.to_owned();
    layers.into_iter().map(|(name, channels)| LayerChannels { name: named(name), channels }).collect()
}
