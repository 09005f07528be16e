"""Films of l20/defi_kidnappe: those of l20/mcl, whose reference sows particles where the scan makes them likely."""

from graders.l20.mcl.replays import replay

REPLAYS = {"kidnappe": replay}
