import asyncio, contextlib, functools
def nombres(n):
    for k in range(n):
        recu = yield k
    return n
async def attend():
    await asyncio.sleep(0)
    return 1
@contextlib.contextmanager
def autour():
    yield 5
@functools.lru_cache
def fib(n):
    return n if n < 2 else fib(n - 1) + fib(n - 2)
class C:
    x: int = 1
    @property
    def double(self):
        return 2 * self.x
def suivre():
    deux = [nombres(3), nombres(3)]
    for _ in range(2):
        for g in deux:
            next(g)
    deux[0].close()
    list(nombres(4)), {k for k in nombres(2)}, sum(k for k in nombres(2))
    coroutine = attend()
    try:
        while True:
            coroutine.send(None)
    except StopIteration:
        pass
    with autour() as cinq:
        fib(6), C().double, sorted([3, 1], key=lambda a: -a)
    return "rien"
