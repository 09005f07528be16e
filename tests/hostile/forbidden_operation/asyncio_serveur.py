import asyncio
def repondre(contexte):
    return str(asyncio.run(asyncio.start_server(None, "127.0.0.1", 0)))
