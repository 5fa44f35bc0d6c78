// Headless Chromium over its debugging pipe: enough of the DevTools protocol for tests, without any package.
import { spawn } from 'node:child_process'
import { mkdtempSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'

const FLAGS = [
  '--headless=new',
  '--no-sandbox',
  '--disable-gpu',
  '--use-gl=angle',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--hide-scrollbars',
  '--no-first-run',
  '--disable-background-networking',
  '--remote-debugging-pipe',
]

export async function openBrowser() {
  const profile = mkdtempSync(join(tmpdir(), 'cairn-browser-'))
  const child = spawn(process.env.CHROMIUM ?? 'chromium', [...FLAGS, `--user-data-dir=${profile}`, 'about:blank'], {
    stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'],
  })
  const waiting = new Map()
  const listeners = []
  let next = 1
  let rest = Buffer.alloc(0)
  child.on('error', (error) => {
    for (const { reject } of waiting.values()) reject(error)
  })
  child.stdio[4].on('data', (bytes) => {
    rest = Buffer.concat([rest, bytes])
    for (let end = rest.indexOf(0); end >= 0; end = rest.indexOf(0)) {
      const message = JSON.parse(rest.subarray(0, end).toString())
      rest = rest.subarray(end + 1)
      const pending = waiting.get(message.id)
      if (pending) {
        waiting.delete(message.id)
        if (message.error) pending.reject(new Error(`${pending.method}: ${message.error.message}`))
        else pending.resolve(message.result)
      } else for (const listener of listeners) listener(message)
    }
  })
  const send = (method, params = {}, sessionId = undefined) =>
    new Promise((resolve, reject) => {
      const id = next++
      waiting.set(id, { resolve, reject, method })
      child.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + '\0')
    })

  const pages = []
  return {
    // Closes what the last test opened.
    async closePages() {
      listeners.length = 0
      for (const targetId of pages.splice(0)) await send('Target.closeTarget', { targetId })
    },
    // Opens a page; `script: false` switches JavaScript off.
    async page(url, { width = 1400, height = 1000, script = true, touch = false } = {}) {
      const { targetId } = await send('Target.createTarget', { url: 'about:blank' })
      pages.push(targetId)
      const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true })
      const call = (method, params) => send(method, params, sessionId)
      const problems = []
      const requests = []
      let loaded
      const load = new Promise((resolve) => (loaded = resolve))
      listeners.push((message) => {
        if (message.sessionId !== sessionId) return
        const p = message.params
        if (message.method === 'Runtime.exceptionThrown')
          problems.push(p.exceptionDetails.exception?.description ?? p.exceptionDetails.text)
        if (message.method === 'Log.entryAdded' && p.entry.level === 'error') problems.push(p.entry.text)
        if (message.method === 'Runtime.consoleAPICalled' && p.type === 'error')
          problems.push(p.args.map((a) => a.value ?? a.description).join(' '))
        if (message.method === 'Network.requestWillBeSent') requests.push(p.request.url)
        if (message.method === 'Page.loadEventFired') loaded()
      })
      for (const domain of ['Page', 'Runtime', 'Log', 'Network']) await call(`${domain}.enable`)
      if (!script) await call('Emulation.setScriptExecutionDisabled', { value: true })
      await call('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: touch })
      await call('Page.navigate', { url })
      await load
      const evaluate = async (expression) => {
        const result = await call('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true })
        if (result.exceptionDetails) throw new Error(result.exceptionDetails.exception?.description)
        return result.result.value
      }
      const settle = () => new Promise((resolve) => setTimeout(resolve, 350))
      return {
        call,
        evaluate,
        problems,
        requests,
        settle,
        async until(expression, seconds = 20) {
          for (const end = Date.now() + seconds * 1000; Date.now() < end; ) {
            if (await evaluate(expression)) return
            await new Promise((resolve) => setTimeout(resolve, 50))
          }
          throw new Error(`never true: ${expression}`)
        },
        async mouse(type, x, y, more = {}) {
          await call('Input.dispatchMouseEvent', { type, x, y, button: type === 'mouseMoved' || type === 'mouseWheel' ? 'none' : 'left', clickCount: 1, ...more })
        },
        async click(x, y) {
          await this.mouse('mouseMoved', x, y)
          await this.mouse('mousePressed', x, y)
          await this.mouse('mouseReleased', x, y)
          await settle()
        },
        async screenshot(full = false) {
          await settle()
          const { data } = await call('Page.captureScreenshot', { format: 'png', captureBeyondViewport: full })
          return Buffer.from(data, 'base64')
        },
      }
    },
    async close() {
      await send('Browser.close').catch(() => {})
      await new Promise((resolve) => (child.exitCode === null ? child.on('exit', resolve) : resolve()))
      rmSync(profile, { recursive: true, force: true, maxRetries: 5 })
    },
  }
}
