-- What Neovim shows of a robot program: asserted one after the other, ends with status 0 when all held.
local function wait(what, test)
  if not vim.wait(30000, test, 20) then
    error('did not come: ' .. what)
  end
end

local function told(code)
  return vim.tbl_filter(function(found)
    return found.code == code
  end, vim.diagnostic.get(0))
end

local function line_of(text)
  for number, line in ipairs(vim.api.nvim_buf_get_lines(0, 0, -1, false)) do
    if line:find(text, 1, true) then
      return number
    end
  end
  error('no line ' .. text)
end

local function shown(namespace)
  return vim.api.nvim_buf_get_extmarks(0, vim.api.nvim_get_namespaces()[namespace], 0, -1, { details = true })
end

local function checks()
  vim.cmd('edit ' .. vim.g.jobs .. '/HANDLING.JBI')
  wait('the client', function()
    return #vim.lsp.get_active_clients() == 1
  end)

  -- Hints: asked for by the lines of README, and seen behind every move.
  wait('hints', function()
    return #shown('olp-times') > 5
  end)
  local first = shown('olp-times')[1]
  assert(first[4].virt_text[1][1]:find('Σ'), 'a hint holds the running total')
  assert(vim.fn.getline(first[2] + 1):find('MOV'), 'and stands behind a move')

  -- A mistake is told while it is typed, and gone when it is mended.
  local number = line_of('MOVJ C00001')
  local good = vim.fn.getline(number)
  vim.fn.setline(number, 'MOVJ C00001 VJ=')
  wait('P020', function()
    local found = told('P020')
    return #found == 1 and found[1].lnum == number - 1
  end)
  vim.fn.setline(number, good)
  wait('no P020', function()
    return #told('P020') == 0
  end)

  -- Hover, in its window.
  vim.fn.cursor(line_of('MOVL C00002 V=250'), 7)
  vim.lsp.buf.hover()
  local text = ''
  wait('hover', function()
    for _, window in ipairs(vim.api.nvim_list_wins()) do
      if vim.api.nvim_win_get_config(window).relative ~= '' then
        local buffer = vim.api.nvim_win_get_buf(window)
        text = table.concat(vim.api.nvim_buf_get_lines(buffer, 0, -1, false), '\n')
      end
    end
    return text ~= ''
  end)
  for _, part in ipairs({ ' mm', 'reached', 'limited by', 'ends at X ' }) do
    assert(text:find(part, 1, true), part .. ' in ' .. text)
  end
  vim.cmd('silent! only!')

  -- The cursor goes to where the point is taught.
  vim.fn.cursor(line_of('MOVJ C00001'), 7)
  vim.lsp.buf.definition()
  wait('definition', function()
    return vim.fn.getline('.'):find('^C00001=') ~= nil
  end)

  -- And from a call into the other file.
  vim.fn.cursor(line_of('CALL JOB:DROP'), 11)
  vim.lsp.buf.definition()
  wait('definition elsewhere', function()
    return vim.fn.expand('%:t') == 'DROP.JBI' and vim.fn.getline('.'):find('^//NAME DROP') ~= nil
  end)
  vim.cmd('buffer HANDLING.JBI')

  -- The lens above the program, with its budget.
  wait('code lenses', function()
    return #vim.lsp.codelens.get(0) == 2
  end)
  local titles = {}
  for _, lens in ipairs(vim.lsp.codelens.get(0)) do
    table.insert(titles, lens.command.title)
  end
  local said = table.concat(titles, '\n')
  assert(said:find('motion') and said:find('budget cell 4: ') and said:find('s left'), said)

  -- A quick fix, chosen and done.
  vim.cmd('edit ' .. vim.g.jobs .. '/labels.jbi')
  wait('W014', function()
    return #told('W014') > 0
  end)
  local label = told('W014')[1].lnum + 1
  local gone = vim.fn.getline(label)
  vim.fn.cursor(label, 1)
  vim.ui.select = function(actions, _, choose)
    for _, action in ipairs(actions) do
      local inner = action[2] or action.action
      if inner.isPreferred then
        return choose(action)
      end
    end
    error('no quick fix among ' .. vim.inspect(actions))
  end
  vim.lsp.buf.code_action()
  wait('the fix', function()
    return vim.fn.getline(label) ~= gone
  end)
end

local ok, problem = pcall(checks)
io.stderr:write(ok and 'neovim: hints, findings, hover, definitions, lenses and a quick fix were seen' or tostring(problem))
for _, client in ipairs(vim.lsp.get_active_clients()) do
  client.stop()
end
vim.cmd(ok and 'qall!' or 'cquit!')
