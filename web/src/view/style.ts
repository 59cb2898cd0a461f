/** Style of the view. The backdrops are the same in both colour schemes. */

export const STYLE = `
.sb-view { position: relative; overflow: hidden; container-type: inline-size; width: 100%;
  height: 100%; min-height: 16rem; color: #dbe6ef;
  background: radial-gradient(ellipse at 50% 42%, #16202b 0%, #0b1118 62%, #070b10 100%); }
.sb-view[data-backdrop="dusk"] {
  background: linear-gradient(#0a1326 0%, #17294a 28%, #4a5b78 50%, #7b8390 66%, #6c727c 100%); }
.sb-view[data-backdrop="day"] {
  background: linear-gradient(#5f95cf 0%, #a9cbea 34%, #e4eef7 54%, #e6ebf2 100%); }
.sb-view canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
.sb-view .sb-field { touch-action: pan-y; cursor: grab; }
.sb-view .sb-field:active { cursor: grabbing; }
.sb-view .sb-field:focus-visible { outline: 2px solid #8cc8ff; outline-offset: -4px; }
.sb-view:not([data-backdrop="dark"]):has(.sb-field:focus-visible)::after { content: ""; position: absolute; inset: 2px;
  border: 2px solid #8cc8ff; border-radius: 0.25rem; pointer-events: none; }
.sb-view .sb-picture { pointer-events: none; background: #05080b; }
.sb-view:not([data-backdrop="dark"]) .sb-field { mask-composite: intersect;
  mask-image: linear-gradient(90deg, #0000, #0003 5%, #000c 14%, #000 22% 78%, #000c 86%, #0003 95%, #0000),
  linear-gradient(#000 70%, #000c 85%, #0000); }
.sb-layer { position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
.sb-lamp { position: absolute; width: 2.25rem; height: 2.25rem; margin: -1.125rem; padding: 0; border: 0;
  border-radius: 50%; z-index: 1; pointer-events: auto; cursor: move; touch-action: none;
  background: radial-gradient(circle, #fff7e0 0 12%, #ffe9b473 30%, #ffe9b400 68%); }
.sb-lamp::after { content: ""; position: absolute; inset: 0.5rem; border: 1px solid #ffeec4b3; border-radius: 50%; }
.sb-lamp:hover::after { border-color: #fff; }
.sb-lamp:focus-visible { outline: 2px solid #8cc8ff; outline-offset: -2px; }
.sb-lamp.sb-behind { background: none; }
.sb-lamp.sb-behind::after { border-style: dashed; opacity: 0.55; }
.sb-split { position: absolute; top: 0; bottom: 0; width: 2.5rem; margin-left: -1.25rem; padding: 0; border: 0;
  background: linear-gradient(#dbe6efcc, #dbe6efcc) 50% / 1px 100% no-repeat; cursor: ew-resize; touch-action: none;
  pointer-events: auto; }
.sb-split::after { content: ""; position: absolute; left: 0.875rem; top: 20%; width: 0.75rem;
  height: 2.5rem; border-radius: 0.375rem; background: #dbe6ef; }
.sb-split:focus-visible { outline: none; }
.sb-split:focus-visible::after { outline: 2px solid #8cc8ff; outline-offset: 2px; }
.sb-caption { position: absolute; bottom: 0.625rem; max-width: calc(50% - 1.25rem); padding: 0.125rem 0.5rem;
  border-radius: 0.25rem; background: #070b10d9; color: #dbe6ef; font-size: 0.8125rem; line-height: 1.4;
  font-variant-numeric: tabular-nums; }
.sb-caption:first-of-type { left: 0.75rem; }
.sb-caption + .sb-caption { right: 0.75rem; text-align: right; }
.sb-probe { position: absolute; top: 0.75rem; left: 0.75rem; width: 12rem; padding: 0.625rem 0.75rem 0.375rem;
  border-radius: 0.5rem; background: #070b10e6; color: #dbe6ef; font-size: 0.8125rem; line-height: 1.35; }
.sb-probe.sb-right { left: auto; right: 0.75rem; }
.sb-probe div:first-child { display: flex; gap: 0.625rem; align-items: center; min-height: 2.25rem; }
.sb-probe-color { flex: none; width: 2.25rem; height: 2.25rem; border-radius: 0.375rem;
  border: 1px solid #dbe6ef59; }
.sb-probe-curve { margin-top: 0.375rem; }
.sb-probe svg { display: block; max-width: 100%; }
@container (max-width: 35rem) {
  .sb-probe, .sb-probe.sb-right { top: 0.375rem; left: 0.375rem; right: 0.375rem; width: auto; display: flex;
    gap: 0.5rem; align-items: center; padding: 0.25rem 0.5rem; font-size: 0.75rem; }
  .sb-probe > div { flex: 1 1 50%; min-width: 0; }
  .sb-probe-curve { margin: 0; }
}
.sb-probed { position: absolute; width: 0.875rem; height: 0.875rem; margin: -0.4375rem; border-radius: 50%;
  border: 2px solid #fff; box-shadow: 0 0 0 1px #070b10, inset 0 0 0 1px #070b10; }
.sb-view [hidden] { display: none; }
`;
