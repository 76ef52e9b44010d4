// Writes files as a whole.
#include "fracture/new_file.h"

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace
{
/// The end of a chain of symbolic links. Empty, with an error: there is none.
std::filesystem::path FollowLinks(std::filesystem::path path, std::error_code* error)
{
    constexpr int maxLinks = 40; // the limit of Linux
    for (int i = 0; i < maxLinks; i++)
    {
        if (!std::filesystem::is_symlink(std::filesystem::symlink_status(path, *error)))
            return path;
        const std::filesystem::path target = std::filesystem::read_symlink(path, *error);
        if (*error)
            return {};
        path = path.parent_path() / target; // an absolute target stands alone
    }
    *error = std::make_error_code(std::errc::too_many_symbolic_link_levels);
    return {};
}

/// A new file beside another one, which it replaces, or whose name it gets, when it is complete.
class NewFile
{
  public:
    /// A symbolic link stays: the file behind it is replaced. What is no file, as a pipe, is written itself.
    explicit NewFile(const std::string& path)
    {
        std::error_code error;
        const std::filesystem::file_status old = std::filesystem::status(path, error);
        m_isDirect = std::filesystem::exists(old) && !std::filesystem::is_regular_file(old);
        if (m_isDirect)
        {
            m_name = path;
            OpenStream(open(path.c_str(), O_WRONLY | O_CLOEXEC));
            return;
        }
        m_target = FollowLinks(path, &error).string();
        if (m_target.empty())
        {
            m_error = error.value();
            return;
        }
        OpenStream(Create());
        if (m_stream != nullptr && std::filesystem::exists(old))
            std::filesystem::permissions(m_name, old.permissions(), error);
    }

    NewFile(const NewFile&) = delete;
    NewFile& operator=(const NewFile&) = delete;

    ~NewFile()
    {
        if (m_stream != nullptr)
            std::fclose(m_stream);
        if (m_isTemporary)
            std::remove(m_name.c_str());
    }

    bool IsOpen() const
    {
        return m_stream != nullptr;
    }

    /// Why it is not open: a number of errno.
    int GetError() const
    {
        return m_error;
    }

    /// False, with errno: the old file is as it was.
    bool Write(const std::vector<char>& bytes)
    {
        if (std::fwrite(bytes.data(), 1, bytes.size(), m_stream) != bytes.size())
            return false;
        // Some file systems report a full disk here only.
        const bool isClosed = std::fclose(m_stream) == 0;
        m_stream = nullptr;
        if (!isClosed || m_isDirect)
            return isClosed;
        m_isTemporary = std::rename(m_name.c_str(), m_target.c_str()) != 0;
        return !m_isTemporary;
    }

  private:
    /// A new file beside the target, with the permissions that files of this process get.
    int Create()
    {
        static std::atomic<unsigned> s_last{0};
        int descriptor;
        do
        {
            m_name = m_target + "." + std::to_string(getpid()) + "." + std::to_string(++s_last);
            descriptor = open(m_name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        } while (descriptor < 0 && errno == EEXIST);
        m_isTemporary = descriptor >= 0;
        return descriptor;
    }

    void OpenStream(int descriptor)
    {
        m_stream = descriptor >= 0 ? fdopen(descriptor, "wb") : nullptr;
        m_error = m_stream == nullptr ? errno : 0;
        if (m_stream == nullptr && descriptor >= 0)
            close(descriptor);
    }

    std::string m_target, m_name;
    std::FILE* m_stream = nullptr;
    int m_error = 0;
    bool m_isDirect;
    bool m_isTemporary = false; ///< the file m_name is to be removed
};
} // namespace

std::string qcWriteFile(const char* path, const std::vector<char>& bytes)
{
    NewFile file(path);
    if (!file.IsOpen())
        return std::string(path) + " can't be created: " + std::strerror(file.GetError());
    return file.Write(bytes) ? "" : std::string(path) + " can't be written: " + std::strerror(errno);
}
