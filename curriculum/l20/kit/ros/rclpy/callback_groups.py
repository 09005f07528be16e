"""Les groupes de fonctions : sans effet ici, où elles sont appelées l'une après l'autre."""


class CallbackGroup:
    pass


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    pass


class ReentrantCallbackGroup(CallbackGroup):
    pass
