;;; What Emacs gets to know of a robot program: asserted one after the other.  -*- lexical-binding: t -*-

(require 'cl-lib)
(require 'flymake)
(require 'xref)

(defun check-wait (what test)
  "Until TEST holds; WHAT is said where it never does."
  (let ((end (+ (float-time) 30)))
    (while (not (funcall test))
      (when (> (float-time) end) (error "Did not come: %s" what))
      (accept-process-output nil 0.05))))

(defun check-told (pattern)
  "The findings of the buffer whose text matches PATTERN."
  (cl-remove-if-not (lambda (found) (string-match-p pattern (flymake-diagnostic-text found)))
                    (flymake-diagnostics)))

(defun check-goto (text)
  "To the beginning of the line that begins with TEXT."
  (goto-char (point-min))
  (re-search-forward (concat "^" (regexp-quote text)))
  (beginning-of-line))

(defun check-ask (method &rest more)
  "The server's answer about the buffer."
  (jsonrpc-request (eglot-current-server) method
                   (append (list :textDocument (eglot--TextDocumentIdentifier)) more)))

(defun check-open (file)
  "FILE of the jobs, with its server running and its first findings there."
  (find-file (expand-file-name file (getenv "JOBS")))
  (unless (eq major-mode 'robot-program-mode) (error "The mode of %s is %s" file major-mode))
  (unless (eglot-current-server)
    (apply #'eglot--connect (eglot--guess-contact)))
  (check-wait "the server" #'eglot-current-server)
  (unless (eglot-managed-p) (eglot--maybe-activate-editing-mode))
  (flymake-mode 1)
  (flymake-start))

(let ((eglot-sync-connect t))
  (setq project-find-functions nil)
  (check-open "HANDLING.JBI")

  ;; Hints, by request: this Eglot shows none.
  (let* ((range (list :start '(:line 0 :character 0) :end '(:line 1000 :character 0)))
         (hints (check-ask :textDocument/inlayHint :range range)))
    (cl-assert (> (length hints) 5))
    (cl-assert (string-match-p "Σ" (plist-get (aref hints 0) :label))))

  ;; A mistake is told while it is typed.
  (check-goto "MOVJ C00001")
  (end-of-line)
  (insert " VJ=")
  (eglot--signal-textDocument/didChange)
  (check-wait "P020" (lambda () (check-told "P020\\|VJ=")))
  (delete-char -4)
  (eglot--signal-textDocument/didChange)
  (check-wait "no P020" (lambda () (null (check-told "P020\\|VJ="))))

  ;; Hover, definition here and in another file, the outline.
  (check-goto "MOVL C00002 V=250")
  (forward-char 6)
  (let ((text (plist-get (plist-get (check-ask :textDocument/hover :position (eglot--pos-to-lsp-position))
                                    :contents)
                         :value)))
    (dolist (part '(" mm" "reached" "limited by" "ends at X "))
      (cl-assert (string-match-p (regexp-quote part) text) nil "%s in %s" part text)))
  (check-goto "MOVJ C00001")
  (forward-char 6)
  (xref-find-definitions "LSP identifier at point.")
  (cl-assert (looking-at "C00001="))
  (check-goto "CALL JOB:DROP")
  (forward-char 10)
  (xref-find-definitions "LSP identifier at point.")
  (cl-assert (string= (file-name-nondirectory buffer-file-name) "DROP.JBI"))
  (cl-assert (string= (buffer-substring (line-beginning-position) (line-end-position)) "//NAME DROP"))
  (switch-to-buffer "HANDLING.JBI")
  (cl-assert (imenu--make-index-alist t))

  ;; The lens with its budget, by request: Eglot shows none.
  (let ((titles (mapconcat (lambda (lens) (plist-get (plist-get lens :command) :title))
                           (check-ask :textDocument/codeLens) "\n")))
    (cl-assert (string-match-p "motion" titles))
    (cl-assert (string-match-p "budget cell 4: .* s left" titles)))

  ;; A quick fix, done by Eglot.
  (check-open "labels.jbi")
  (check-wait "W014" (lambda () (check-told "nothing jumps to")))
  (goto-char (flymake-diagnostic-beg (car (check-told "nothing jumps to"))))
  (let ((gone (buffer-substring (line-beginning-position) (line-end-position)))
        (fix (cl-find-if (lambda (action) (eq (plist-get action :isPreferred) t))
                         (check-ask :textDocument/codeAction
                                    :range (list :start (eglot--pos-to-lsp-position)
                                                 :end (eglot--pos-to-lsp-position))
                                    :context '(:diagnostics [])))))
    (cl-assert fix)
    (eglot--apply-workspace-edit (plist-get fix :edit))
    (goto-char (point-min))
    (cl-assert (not (re-search-forward (concat "^" (regexp-quote gone) "$") nil t))))

  (eglot-shutdown (eglot-current-server))
  (message "emacs: hints, findings, hover, definitions, outline, lenses and a quick fix were answered")
  (set-buffer-modified-p nil)
  (kill-emacs 0))
