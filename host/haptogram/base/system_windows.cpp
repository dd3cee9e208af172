// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <windows.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <thread>

#include "haptogram/base/system.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram::system {

namespace fs = std::filesystem;
namespace {

/// Windows numbers its reasons otherwise than errno.
void keep_reason() {
    errno = std::system_category().default_error_condition(static_cast<int>(::GetLastError())).value();
}

/// As CommandLineToArgvW reads it.
std::wstring quoted(const std::string& argument) {
    std::wstring text = L"\"";
    std::size_t backslashes = 0;
    for (const wchar_t c : fs::path(argument).wstring()) {
        if (c == L'"') text.append(backslashes + 1, L'\\');
        backslashes = c == L'\\' ? backslashes + 1 : 0;
        text += c;
    }
    return text.append(backslashes, L'\\') + L"\" ";
}

/// A file for a program that is started.
class Handle {
public:
    Handle(const fs::path& file, DWORD access, DWORD how) {
        SECURITY_ATTRIBUTES inherited{sizeof(SECURITY_ATTRIBUTES), nullptr, TRUE};
        handle_ = ::CreateFileW(file.empty() ? L"NUL" : file.c_str(), access, FILE_SHARE_READ | FILE_SHARE_WRITE,
                                &inherited, file.empty() ? OPEN_EXISTING : how, FILE_ATTRIBUTE_NORMAL, nullptr);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() { ::CloseHandle(handle_); }
    [[nodiscard]] HANDLE get() const { return handle_; }

private:
    HANDLE handle_;
};

}  // namespace

int open_to_read(const fs::path& path) { return ::_wopen(path.c_str(), _O_RDONLY | _O_BINARY | _O_NOINHERIT); }
int open_pipe(const fs::path&) {
    errno = ENOSYS;  // a named pipe has no path here
    return -1;
}
int open_to_write(const fs::path& path) { return ::_wopen(path.c_str(), _O_WRONLY | _O_BINARY | _O_NOINHERIT); }

std::pair<int, fs::path> create_beside(const fs::path& target) {
    for (;;) {
        fs::path name = target;
        name += "." + make_token().substr(0, 8);
        const int descriptor =
            ::_wopen(name.c_str(), _O_RDWR | _O_CREAT | _O_EXCL | _O_BINARY | _O_NOINHERIT, _S_IREAD | _S_IWRITE);
        if (descriptor >= 0 || errno != EEXIST) return {descriptor, name};
    }
}

bool is_file(int descriptor) {
    return ::GetFileType(reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor))) == FILE_TYPE_DISK;
}

int standard(int descriptor) {
    ::_setmode(descriptor, _O_BINARY);
    return descriptor;
}
void close(int descriptor) { ::_close(descriptor); }
std::ptrdiff_t read(int descriptor, char* to, std::size_t most) {
    return ::_read(descriptor, to, static_cast<unsigned>(std::min<std::size_t>(most, INT_MAX)));
}
std::ptrdiff_t write(int descriptor, const char* from, std::size_t most) {
    return ::_write(descriptor, from, static_cast<unsigned>(std::min<std::size_t>(most, INT_MAX)));
}
bool sync(int descriptor) { return ::_commit(descriptor) == 0; }

bool give_name(int, const fs::path&) { return true; }

bool rename(const fs::path& from, const fs::path& to) {
    if (::MoveFileExW(from.c_str(), to.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) != 0) return true;
    keep_reason();
    return false;
}

bool wait_to_write(int, std::chrono::milliseconds) { return true; }
bool wait_to_read(int descriptor, std::chrono::milliseconds patience) {
    const auto handle = reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
    if (::GetFileType(handle) == FILE_TYPE_CHAR)
        return ::WaitForSingleObject(handle, static_cast<DWORD>(patience.count())) == WAIT_OBJECT_0;
    // A pipe cannot be waited for, and a file need not.
    const auto end = std::chrono::steady_clock::now() + patience;
    for (DWORD there = 0; ::PeekNamedPipe(handle, nullptr, 0, nullptr, &there, nullptr) != 0 && there == 0;) {
        if (std::chrono::steady_clock::now() >= end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

void widen_pipe(int) {}

fs::path create_folder(const fs::path& in) {
    for (;;) {
        const fs::path name = in / ("haptogram-" + make_token().substr(0, 8));
        std::error_code error;
        if (fs::create_directory(name, error)) return name;
        if (error) {
            errno = error.default_error_condition().value();
            return {};
        }
    }
}

int run(const fs::path& folder, const std::vector<std::string>& command, const fs::path& input, const fs::path& output,
        const fs::path& said) {
    const Handle in(input, GENERIC_READ, OPEN_EXISTING), out(output, GENERIC_WRITE, CREATE_ALWAYS),
        errors(said, GENERIC_WRITE, CREATE_ALWAYS);
    STARTUPINFOW start{};
    start.cb = sizeof start;
    start.dwFlags = STARTF_USESTDHANDLES;
    start.hStdInput = in.get();
    start.hStdOutput = out.get();
    start.hStdError = errors.get();
    std::wstring line;
    for (const std::string& argument : command) line += quoted(argument);
    PROCESS_INFORMATION child{};
    if (::CreateProcessW(nullptr, line.data(), nullptr, nullptr, TRUE, CREATE_NO_WINDOW, nullptr, folder.c_str(),
                         &start, &child) == 0) {
        keep_reason();
        return -1;
    }
    ::WaitForSingleObject(child.hProcess, INFINITE);
    DWORD code = 0;
    ::GetExitCodeProcess(child.hProcess, &code);
    ::CloseHandle(child.hThread);
    ::CloseHandle(child.hProcess);
    return static_cast<int>(code & 0x7FFFFFFFU);
}

bool is_program(const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}

fs::path own_program() {
    std::array<wchar_t, 32768> name{};
    return {name.data(), name.data() + ::GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size()))};
}

const char between_folders = ';';

double memory_bytes() {
    MEMORYSTATUSEX memory{};
    memory.dwLength = sizeof memory;
    ::GlobalMemoryStatusEx(&memory);
    return static_cast<double>(memory.ullTotalPhys);
}

}  // namespace haptogram::system
