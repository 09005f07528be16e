// The frames of a scene, as the server tells them.

/** Points that a frame does not give again stay where the frame before had them. */
export function keepPlaces(frames) {
  frames.forEach(({ layers }, k) =>
    layers.forEach((layer, i) => {
      if (layer.kind !== "points" || layer.at) return;
      const { at, headings } = frames[k - 1].layers[i];
      Object.assign(layer, { at, headings });
    }),
  );
}
