/* Presses Ctrl-C: interrupt.exe FILE COMMAND LINE...
 * Starts the command in a console of its own, waits for the file to be there, sends the console's event to all in it, and ends with the
 * command's exit code; 100 if the console cannot be had, 101 if the file never comes, 102 if the command does not end. */
#include <stdio.h>
#include <string.h>
#include <windows.h>

#define PATIENCE_MS (10 * 60 * 1000)

static BOOL WINAPI stay(DWORD event) {
  (void)event;
  return TRUE;
}

int main(int count, char **words) {
  char line[4096] = "";
  if (count < 3)
    return 100;
  for (int i = 2; i < count; i++) {
    strncat(line, words[i], sizeof line - strlen(line) - 2);
    strcat(line, " ");
  }
  FreeConsole();
  if (!AllocConsole() || !SetConsoleCtrlHandler(stay, TRUE))
    return 100;
  STARTUPINFOA start = {.cb = sizeof start};
  PROCESS_INFORMATION child;
  if (!CreateProcessA(NULL, line, NULL, NULL, TRUE, 0, NULL, NULL, &start, &child))
    return 100;
  DWORD waited = 0;
  while (GetFileAttributesA(words[1]) == INVALID_FILE_ATTRIBUTES) {
    if (waited > PATIENCE_MS || WaitForSingleObject(child.hProcess, 10) == WAIT_OBJECT_0) {
      TerminateProcess(child.hProcess, 101);
      return 101;
    }
    waited += 10;
  }
  DWORD code = 102;
  if (!GenerateConsoleCtrlEvent(CTRL_C_EVENT, 0))
    code = 100;
  else if (WaitForSingleObject(child.hProcess, PATIENCE_MS) == WAIT_OBJECT_0)
    GetExitCodeProcess(child.hProcess, &code);
  else
    TerminateProcess(child.hProcess, code);
  return (int)code;
}
